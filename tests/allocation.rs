//! A warm steady solve allocates nothing. A binary of its own: the counting allocator is global.
#![allow(missing_docs, clippy::unwrap_used, unsafe_code)]

#[allow(dead_code)]
#[path = "verification/build.rs"]
mod build;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use bmv::expression::Symbol;
use bmv::thermal::{Network, Start};

struct Counting;

thread_local! {
    // By thread: the test harness allocates on its own.
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's obligations are passed on.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        // SAFETY: the caller's obligations are passed on.
        unsafe { System.dealloc(place, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn warm_steady_solves_and_their_derivatives_allocate_nothing() {
    let symbols: Vec<Symbol> = (0..12).map(Symbol::Parameter).collect();
    let network = Network::compile(&build::sxm(), &symbols).unwrap();
    let mut ws = network.workspace();
    network.solve_steady(&mut ws, Start::Default).unwrap();
    let nominal = ws.temperatures().to_vec();
    let mut parameters = network.nominal_parameters().to_vec();
    let mut slopes = vec![0.0; network.quantities() * 12];
    let mut batch = network.batch::<8>();
    let before = ALLOCATIONS.get();
    for i in 0..100 {
        parameters[0] = 0.1 + 1e-3 * f64::from(i);
        network.set_parameters(&mut ws, &parameters);
        network.solve_steady(&mut ws, Start::Temperatures(&nominal)).unwrap();
        network.quantity_tangent(&mut ws, &mut slopes).unwrap();
        batch.set_parameter(3, 0, parameters[0]);
        network.solve_steady_batch(&mut batch, Start::Temperatures(&nominal));
    }
    assert_eq!(ALLOCATIONS.get() - before, 0);
    assert!(before > 0, "the counter counts");
}
