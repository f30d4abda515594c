//! Steppers and runs allocate nothing.
#![allow(unsafe_code, reason = "an allocator that counts")]

use lagrange_runtime::Stepper;
use lagrange_runtime::prelude::*;
use std::alloc::{GlobalAlloc, Layout, System as Heap};
use std::cell::Cell;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        unsafe { Heap.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        unsafe { Heap.dealloc(at, layout) }
    }
}

#[global_allocator]
static HEAP: Counting = Counting;

lagrangian! {
    system Driven {
        param k;
        input u;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = -k * cos(x);
        Q[x] = u;
    }
}

fn allocations(work: impl FnOnce()) -> usize {
    let before = ALLOCATIONS.get();
    work();
    ALLOCATIONS.get() - before
}

#[test]
fn a_stepper_allocates_nothing() {
    fn check<M: Method<Driven, 1> + Clone>(
        method: M,
        controller: impl lagrange_runtime::Controller<f64, 1, M::Error>,
    ) {
        let start = State::new(0.0, [1.0], [0.0]);
        let count = allocations(|| {
            let mut stepper = Stepper::new(Driven::new(1.0), method, controller, start)
                .every(0.01, |state, u| u[0] = -state.qd[0]);
            stepper.advance_to(1.0).unwrap();
            stepper.system_mut().k = 2.0;
            let step = stepper.step().unwrap();
            assert!(stepper.interpolant(&step).is_some());
            let crossed = Event::either(|s: &State<f64, 1>| s.q[0]);
            assert!(stepper.until(5.0).events(crossed).all(|event| event.is_ok()));
            assert!(stepper.until(6.0).sample([5.5, 5.7]).all(|state| state.is_ok()));
            stepper.set_state(start).unwrap();
            stepper.clone().advance_to(2.0).unwrap();
        });
        assert_eq!(count, 0);
    }
    assert_eq!(allocations(|| drop(vec![1])), 1, "it counts");
    check(Rk4, FixedStep::new(0.01));
    check(Gauss4, FixedStep::new(0.01));
    check(Dop853, PiController::tolerance(1e-9));
    check(Radau5, PiController::tolerance(1e-6));
    check(Taylor::of_order(12), TaylorController::tolerance(1e-9));
}
