//! Elaboration of events.

use super::*;
use crate::model::NamedEvent;
use crate::syntax::Event;

impl Elaborator<'_> {
    /// `event ground: y, falling, terminal;`
    pub(super) fn event(&mut self, event: &Event) -> Result<()> {
        let Event { name, value, .. } = event;
        self.event_name(event);
        let Some(expression) = value else { return Err(Reported) };
        self.observing = true;
        self.not_kinetic = Some("an event");
        let val = self.evaluate(expression);
        (self.observing, self.not_kinetic) = (false, None);
        let val = val?;
        let scalar = !matches!(val, Val::Array(_));
        let values = match val {
            Val::Array(items) => {
                items.into_iter().map(|item| self.number(item, expression)).collect::<Result<Vec<_>>>()?
            }
            scalar => vec![self.number(scalar, expression)?],
        };
        if values.is_empty() {
            return Err(self.errors.push(expression, "an array of no events\nhelp: remove this statement"));
        }
        // (An input changes between steps.)
        let fixed: Vec<_> =
            self.found.parameters.iter().filter(|p| !p.input).map(Parameter::numbers).collect();
        let is_fixed =
            |s| matches!(s, Symbol::Parameter(i) if fixed.iter().any(|numbers| numbers.contains(&i)));
        for (i, value) in values.iter().enumerate() {
            let moves = self.graph.depends(&[*value], |s| !is_fixed(s));
            if !moves && self.is_derived() {
                return Ok(());
            }
            if !moves {
                let label = indexed(&name.to_string(), (!scalar).then_some(i));
                let message = format!(
                    "the event `{label}` never happens: its function does not change along a motion\nhelp: let it depend on coordinates, velocities, inputs or `t`"
                );
                return Err(self.errors.push(expression, message));
            }
        }
        self.found.events.push(NamedEvent { written: event.clone(), values, scalar });
        Ok(())
    }

    /// The constant of an event has a name of its own.
    fn event_name(&mut self, event: &Event) {
        let (name, constant) = (&event.name, event.constant());
        if !self.scope.events.insert(constant.clone()) {
            let message = format!(
                "a second event `{name}`, whose constant is `{constant}`\nhelp: give one of them another name"
            );
            self.errors.push(name, message);
        }
    }
}
