//! Vector instructions that the processor has, and code that is compiled for each kind of them. Unsafe code of lanes is
//! here and in `registers.rs`.
//!
//! An ordinary build is for the least processor of its architecture. What is to use the instructions of a better one is
//! compiled again within a function marked by `#[target_feature]`, and called if the processor has them.

#![allow(unsafe_code)]

use core::fmt::Debug;

/// Something to be computed, compiled for the instructions of a [`Processor`]. What it consists of has to be inlined: a
/// function that is called keeps the instructions that it was compiled for, with the same result.
pub trait Work {
    /// Its result.
    type Output;

    /// Does it. Implementations are `#[inline(always)]`.
    fn run(self) -> Self::Output;
}

/// A set of vector instructions. There is no other implementation than those of this module.
pub trait Processor: Copy + Debug + Default + PartialEq + Send + Sync + 'static {
    /// Does the work with these instructions.
    fn call<W: Work>(work: W) -> W::Output;
}

/// The instructions of every processor that the program was built for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Baseline;

impl Processor for Baseline {
    #[inline(always)]
    fn call<W: Work>(work: W) -> W::Output {
        work.run()
    }
}

/// A kind of processor, the best last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// The processor that the program was built for.
    Baseline,
    /// x86 with AVX2 and fused multiply-adds (since 2013).
    Avx2,
    /// x86 with the foundation of AVX-512 and its double and quad word, byte and word, and vector length extensions
    /// (since 2017).
    Avx512,
}

impl Level {
    /// All kinds that this processor is of.
    pub fn available() -> impl Iterator<Item = Level> {
        let best = Level::best();
        [Level::Baseline, Level::Avx2, Level::Avx512].into_iter().filter(move |&level| level <= best)
    }

    /// All kinds that runs in lanes are compiled for and this processor is of: in builds with debug assertions the
    /// least one.
    pub fn compiled() -> impl Iterator<Item = Level> {
        Level::available().filter(|&level| !cfg!(debug_assertions) || level == Level::Baseline)
    }
}

impl Level {
    /// Does the work with AVX2 if the processor has it, and otherwise with the instructions that the program was
    /// built for. Builds for debugging, in which nothing is fast, do not compile it twice.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn call_up_to_avx2<W: Work>(work: W) -> W::Output {
        #[cfg(all(
            target_arch = "x86_64",
            feature = "std",
            not(target_feature = "avx2"),
            not(debug_assertions)
        ))]
        if Level::best() >= Level::Avx2 {
            return Avx2::call(work);
        }
        work.run()
    }

    /// Does the work with the instructions of this kind.
    #[inline]
    pub fn call<W: Work>(self, work: W) -> W::Output {
        match self {
            #[cfg(all(target_arch = "x86_64", feature = "std"))]
            Level::Avx512 => Avx512::call(work),
            #[cfg(all(target_arch = "x86_64", feature = "std"))]
            Level::Avx2 => Avx2::call(work),
            _ => Baseline::call(work),
        }
    }
}

#[cfg(not(all(target_arch = "x86_64", feature = "std")))]
impl Level {
    /// The best kind that this processor is of.
    #[inline]
    pub fn best() -> Self {
        Level::Baseline
    }
}

#[cfg(all(target_arch = "x86_64", feature = "std"))]
pub use x86::{Avx2, Avx512};

#[cfg(all(target_arch = "x86_64", feature = "std"))]
mod x86 {
    use super::{Level, Processor, Work};
    use core::sync::atomic::{AtomicU8, Ordering::Relaxed};

    /// The best kind, as its number and 1; 0 before the first look.
    static BEST: AtomicU8 = AtomicU8::new(0);

    impl Level {
        /// The best kind that this processor is of.
        #[inline]
        pub fn best() -> Self {
            match BEST.load(Relaxed) {
                3 => Level::Avx512,
                2 => Level::Avx2,
                1 => Level::Baseline,
                _ => look(),
            }
        }
    }

    #[cold]
    fn look() -> Level {
        let avx2 = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
        let avx512 = avx2
            && is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512vl");
        let level = match (avx512, avx2) {
            (true, _) => Level::Avx512,
            (_, true) => Level::Avx2,
            _ => Level::Baseline,
        };
        BEST.store(level as u8 + 1, Relaxed);
        level
    }

    macro_rules! processor {
        ($name:ident, $features:literal, $doc:literal) => {
            #[doc = $doc]
            #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
            pub struct $name;

            impl Processor for $name {
                #[cfg_attr(not(debug_assertions), inline(always))]
                fn call<W: Work>(work: W) -> W::Output {
                    #[target_feature(enable = $features)]
                    fn compiled<W: Work>(work: W) -> W::Output {
                        work.run()
                    }
                    assert!(Level::best() >= Level::$name, "this processor lacks {}", $features);
                    // SAFETY: the processor has the instructions that `compiled` is compiled for: it was asked by
                    // `look`.
                    unsafe { compiled(work) }
                }
            }
        };
    }

    processor!(Avx2, "avx2,fma", "AVX2 and fused multiply-adds.");
    processor!(
        Avx512,
        "avx512f,avx512dq,avx512bw,avx512vl,avx2,fma",
        "AVX-512: the foundation, and the extensions for double and quad words, bytes and words, and vector lengths."
    );
}
