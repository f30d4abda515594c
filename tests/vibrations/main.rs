//! Small vibrations, steady motions and stability, against digits of 50-digit arithmetic and closed forms.

mod branches;
mod chain;
mod hypotheses;
mod modal;
mod modes;
mod neighbours;
#[path = "../tables/table.rs"]
mod printed;
mod reference;
mod refused;
mod saltation;
mod small;
mod steady;
mod systems;
mod table;
