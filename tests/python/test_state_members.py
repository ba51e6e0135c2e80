"""Walks the classes that declare a state, for members that are neither declared nor known to be none of it."""

from __future__ import annotations

import re
from pathlib import Path

SOURCES = Path(__file__).resolve().parent.parent.parent / "src"


def plain_text(path: Path) -> str:
    """Without comments and heads of templates."""
    text = re.sub(r"//[^\n]*|/\*.*?\*/", "", path.read_text(), flags=re.DOTALL)
    return re.sub(r"\btemplate\s*<(?:[^<>]|<[^<>]*>)*>", "", text)


def block_after(text: str, begin: int) -> str:
    """What stands between the first brace after a place and the one that closes it."""
    first = text.index("{", begin)
    depth = 0
    for k in range(first, len(text)):
        depth += {"{": 1, "}": -1}.get(text[k], 0)
        if depth == 0:
            return text[first + 1 : k]
    raise AssertionError("a brace is not closed")


def statements(body: str) -> list[str]:
    """Of a class at its own level: without what stands in braces and parentheses."""
    found, current, depth = [], "", 0
    for c in body:
        if c in "})":
            depth -= 1
            # A function's text, or a nested class with no object after it, is over; an initialiser goes on to its semicolon.
            if c == "}" and depth == 0 and "(" in current:
                current = ""
        elif c in "{(":
            current += "(" if c == "(" and depth == 0 else ""
            depth += 1
        elif depth == 0:
            if c == ";":
                found.append(current.strip())
                current = ""
            else:
                current += c
    return found


def data(body: str) -> list[str]:
    """Declarations of what each object has, without initialisers."""
    found = []
    for statement in statements(body):
        plain = re.sub(r"^(\s*(public|private|protected)\s*:)+", "", statement).split("=")[0].strip()
        if plain and "(" not in plain and not re.match(r"(static|using|friend|struct|class|enum|typedef)\b", plain):
            found.append(plain)
    return found


def name_of(declaration: str) -> str:
    """The name, or the names and commas between them."""
    bare = declaration
    while (shorter := re.sub(r"<[^<>]*>", "", bare)) != bare:
        bare = shorter
    declared = re.match(r"[\w:&*\s]*?[\s&*](\w+(\[\w+\])*(\s*,\s*\w+)*)$", bare)
    assert declared, f"a member that this test cannot read: {declaration}"
    return re.sub(r"\[\w+\]", "", declared[1])


def members(body: str) -> list[str]:
    return [name.strip() for one in data(body) for name in name_of(one).split(",")]


def classes(text: str, inside: str = "") -> dict[str, str]:
    """Bodies of all classes of a text, nested ones as Outer::Inner."""
    found = {}
    place = 0
    while match := re.compile(r"\b(?:struct|class)\s+((?:\w+(?:<[^<>]*>)?(?:::)?)+)[^;{}()=]*\{").search(text, place):
        name = inside + re.sub(r"<[^<>]*>", "", match[1])
        body = block_after(text, match.start())
        found[name] = body
        found.update(classes(body, name + "::"))
        place = match.end() + len(body)
    return found


def declarations() -> dict[str, tuple[str, str]]:
    """Class -> its body, and the text of its declare_state."""
    headers = "\n".join(plain_text(path) for path in sorted(SOURCES.rglob("*.hpp")))
    units = "\n".join(plain_text(path) for path in sorted(SOURCES.rglob("*.cpp")))
    found = {}
    for text in (headers, units):
        for name, body in classes(text).items():
            flat = body
            for nested in classes(body).values():
                flat = flat.replace(nested, "")
            match = re.search(r"\bvoid declare_state\((?:\w+::)?State&\s*\w*\)[^;{]*([;{])", flat)
            if not match:
                continue
            if match[1] == "{":
                found[name] = (body, block_after(flat, match.start()))
            else:
                last = name.split("::")[-1]
                outside = re.search(rf"\b{last}(?:<[^<>]*>)?::declare_state\([^)]*\)\s*\{{", units)
                if outside:
                    found[name] = (body, block_after(units, outside.start()))
    for name, (body, declared) in list(found.items()):
        # What it declares of a class of its own that declares nothing.
        for nested, inner in classes(body).items():
            holders = [name_of(one) for one in data(body) if re.search(rf"\b{nested}\b", one)]
            if any(re.search(rf"\b{holder}\b", declared) for holder in holders):
                found.setdefault(f"{name}::{nested}", (inner, declared))
    return found


# What a class has beside its state, and why that is none.
GIVEN = "the case gives it, or the objects that were made from the case"
ANEW = "made anew before it is read: in each step, or where it is first asked for"
REPORTS = "measured for messages, profiles and files; no step reads it"
LOADED = "follows from what is declared, and is set when that is loaded"
RUN = "of the process, not of the problem: who listens, spare memory, what is on its way to a file, what has failed"
UNDECLARED = {
    "AppliedLoads": {GIVEN: "loads_ bodies_ places_ first_ period_", ANEW: "now_ before_"},
    "BodyContact": {GIVEN: "images_ friction_", ANEW: "patches_ pattern_ places_ entry_ x0_ x_ searched_at_", REPORTS: "energy_"},
    "BodyContact::Pair": {GIVEN: "kernel stiffness", ANEW: "shifts"},
    "BoundaryTotals": {GIVEN: "name"},
    "CellBlocks": {LOADED: "slots_ blocks_"},
    "CellBlocks::Band": {ANEW: "leaving", LOADED: "rows blocks is_list_old", RUN: "unused unused_slots"},
    "Contact": {GIVEN: "bodies_ conditions_ friction_"},
    "ExplicitSolver": {
        GIVEN: "node_positions_ stress_order_ fmpm_order_ kernels_ geometry_ boundary_conditions_ has_obstacles_ holds_",
        ANEW: "body_force_values_ load_time_",
        REPORTS: "profile_",
    },
    "FaceContacts": {GIVEN: "conditions_", ANEW: "released_ sets_ held_ slipping_ unsettled_"},
    "FaceContacts::Node": {GIVEN: "condition axis inward can_slip friction slot", ANEW: "changes slips turns"},
    "FemBody": {
        GIVEN: "cells_ nodes_of_body_ undeformed_ cell_rows_ output_cells_ functions_ nodes_ N_ weight_ratio_ receding_correction_ "
        "depths_ cell_length_"
    },
    "FluidCorrection": {GIVEN: "has_filter_ grid_ conditions_ fluids_ fillers_ lengths_ cell_size_"},
    "Grid": {
        GIVEN: "lower_ upper_ cell_size_ cells_ is_periodic_ has_periodic_ shape_ span_ band_rows_ conditions_ is_refined_ kernels_",
        ANEW: "body_force_ pass_ pass_count_ dynamics_ dt_ boundary_velocities_ boundary_velocities_before_ sums_ books_",
        LOADED: "tiles_",
    },
    "Grid::Band": {RUN: "unused"},
    "Health": {GIVEN: "is_explicit_"},
    "Health::Range": {GIVEN: "column"},
    "ImplicitSolver": {
        GIVEN: "spec_ geometry_ conditions_ particles_ fem_bodies_ tractions_ point_loads_",
        ANEW: "assembly_ newton_ work_at_start_ load_work_at_start_",
        REPORTS: "profile_ step_seconds_ linear_iterations_",
        LOADED: "escapes_ escaped_rows_",
    },
    "Ledger": {ANEW: "boundaries"},
    "NodalWork": {REPORTS: "start_ end_"},
    "PairContact": {GIVEN: "images_ friction_ stable_dt_", REPORTS: "energy_ dissipated_"},
    "PairContact::Pair": {GIVEN: "bodies kernel stiffness"},
    "PairContact::Points": {GIVEN: "body density modulus spacing"},
    "PairContact::Points::Place": {ANEW: "way"},
    "ParticleBody": {
        GIVEN: "name_ material_ scheme_ grid_ kernels_ uniform_volume_ smallest_volume_ has_fbar_ reach_",
        ANEW: "seats_ reports_ arrivals_ call_",
        REPORTS: "dissipated_ bad_point_ moved_",
    },
    "PointBody": {GIVEN: "name_"},
    "ResultsFolder": {RUN: "existing_ lock_ watch_ taken_step_ fields_ state_ writing_"},
    "ResultsFolder::Writers": {GIVEN: "fields"},
    "RigidMotion": {GIVEN: "spec_ start_pivot_ arm_ mass_ axes_ moments_ fixed_axis_ inertia_ is_turn_held_"},
    "SideContact": {GIVEN: "modulus_ slope_ is_static_", ANEW: "displacements_ near_ is_near_", REPORTS: "energy_"},
    "SideContact::Side": {GIVEN: "axis inward condition friction", ANEW: "shifts"},
    "Simulation": {GIVEN: "case_", REPORTS: "health_lines_", RUN: "callbacks_ history_callbacks_ is_changed_by_hand_ broken_"},
    "StepSpace": {
        GIVEN: "conditions_ soft_stiffness_ has_own_fields_ moves_basis_ functions_ is_fem_cell_ is_fem_node_ is_border_cell_ "
        "receding_faces_",
        ANEW: "cell_source_ particles_ cell_begin_ soft_factors_ N_ gradients_ corrected_ corrected_gradients_ receding_count_ nodes_ "
        "slots_ cell_nodes_ unknowns_ unknown_count_ pattern_",
        REPORTS: "penetrated_count_",
    },
    "Tools": {GIVEN: "grid_ half_min_ k_over_m_", LOADED: "energy_", ANEW: "number_"},
    "Tools::Touched": {
        GIVEN: "modulus mass volume half laid",
        LOADED: "forces places touches",
        ANEW: "last_forces last_places",
    },
    "Tools::Tool": {GIVEN: "shape friction stiffness", REPORTS: "overlap", LOADED: "k_sum force torque", ANEW: "way turn"},
    "VtkHdfSeries": {GIVEN: "folder_ name_ real_ compression_ grid_ dim_", RUN: "is_behind_"},
    "VtuSeries": {GIVEN: "folder_ name_ real_ grid_"},
}


def test_every_member_is_declared_or_known_to_be_no_state() -> None:
    found = declarations()
    assert len(found) > 30, sorted(found)
    unknown, stale = [], []
    for name, (body, declared) in found.items():
        listed = {member for text in UNDECLARED.get(name, {}).values() for member in text.split()}
        missing = {member for member in members(body) if not re.search(rf"\b{member}\b", declared)}
        unknown += [f"{name}::{member}" for member in sorted(missing - listed)]
        stale += [f"{name}::{member}" for member in sorted(listed - missing)]
    stale += sorted(set(UNDECLARED) - set(found))
    assert not unknown, f"declare these in declare_state, or say in this file why they are no state: {unknown}"
    assert not stale, f"listed as no state, but declared or gone: {stale}"
