mod harness;
mod tmp;
