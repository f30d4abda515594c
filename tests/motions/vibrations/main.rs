//! Small vibrations, steady motions and stability, against digits of 50-digit arithmetic and closed forms.

mod branches;
mod chain;
mod modal;
mod modes;
mod neighbours;
mod reference;
mod refused;
mod saltation;
mod small;
mod steady;
mod systems;
