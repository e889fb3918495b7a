"""Makes importable what the product embeds and therefore owns: the reference formulas in JAX."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2] / "src/audit/oracles/golden"))
