//! The rows by hand of a type for every tile, in one call of the vector unit.

use super::{hessian, simd, simd_values};
use pintle_kinematics::batch::{Four, HessianRow, Row, Section, Tile};
use pulp::x86::V3;

/// A type, its tiles, and room for so many rows of each; what is left without room is left out.
pub(crate) struct Sweep<'a, L> {
    pub(crate) v: V3,
    pub(crate) name: &'a str,
    pub(crate) tiles: &'a [Tile],
    pub(crate) sections: &'a [Section],
    pub(crate) rows: usize,
    pub(crate) out: &'a mut [L],
}

/// Loops written out: a closure would be compiled for the baseline, and called.
macro_rules! sweep {
    ($layout:ty, $module:ident) => {
        impl pulp::NullaryFnOnce for Sweep<'_, $layout> {
            type Output = ();

            #[inline(always)]
            fn call(self) {
                let Self { v, name, tiles, sections, rows, out } = self;
                let all = tiles.iter().zip(sections).zip(out.chunks_exact_mut(rows));
                match name {
                    "SLIDE-PLANE" => {
                        for ((tile, _), rows) in all {
                            $module::slide_plane(v, tile, rows);
                        }
                    }
                    "REVOLUTE" => {
                        for ((tile, _), rows) in all {
                            $module::revolute(v, tile, rows);
                        }
                    }
                    "TRANSLATOR" => {
                        for ((tile, section), rows) in all {
                            $module::translator(v, tile, section, rows);
                        }
                    }
                    "ROTATION" => {
                        for ((tile, _), rows) in all {
                            $module::rotation(v, tile, rows);
                        }
                    }
                    _ => {
                        for ((tile, _), rows) in all {
                            $module::cardan(v, tile, rows);
                        }
                    }
                }
            }
        }
    };
}

sweep!(Four, simd_values);
sweep!(Row, simd);
sweep!(HessianRow, hessian);
