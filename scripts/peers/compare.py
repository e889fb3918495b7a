"""Motions and joint coordinates of other programs, written as files and compared by `pintle compare`.

    python3 scripts/peers/compare.py [--program target/release/pintle]

| program | joints | connector | what is compared |
|---|---|---|---|
| MuJoCo | hinge, slide | HINGE, TRANSLATOR | joint angle and displacement with their rates; the moment of a spring and damper |
| Pinocchio | three revolutes about x, y, z | CARDAN | the three angles |
| Pinocchio | a point of two free bodies | JOIN | the constraint Jacobian, by NumPy and SciPy files |
| Exudyn | rotation of a rigid body | ROTATION | rotation vector |
| CalculiX | displacements of nodes | CARTESIAN | the difference of displacements |
| CalculiX | springs | CARTESIAN | reactions of the nodes, as it prints them |

Each right file must agree. Each of its faults (degrees, a sign, a lost turn, an increment too late) must be found and named. Pinocchio's
Jacobian departs from pintle's in its sign and axes: that must be found, too.
A program that is not installed is left out, and the last line says how many were not.
"""

import argparse
import csv
import pathlib
import shutil
import subprocess
import tempfile

import numpy as np

HINGE = """*NODE
1, 0., 0., 0.
2, 0., 0., 0.
*ORIENTATION, NAME=OA
0., 0., 1., 1., 0., 0.
*ELEMENT, TYPE=CONN3D2, ELSET=C
7, 1, 2
*CONNECTOR SECTION, ELSET=C
{type}
OA, OA
"""


def write(path, rows):
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)


def run(program, deck, files, folder, more=()):
    (folder / "deck.inp").write_text(deck)
    command = [program, "compare", "deck.inp", "--against", *files, *more]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    return done.returncode, " ".join(done.stdout.split()) + done.stderr


def check(program, name, deck, nodes, outputs, faults):
    """The right files agree; each fault is named. `faults`: what is done to the outputs or nodes, and the words of its cause."""
    tried = 0
    with tempfile.TemporaryDirectory() as made:
        folder = pathlib.Path(made)
        write(folder / "nodes.csv", nodes)
        write(folder / "outputs.csv", outputs)
        code, text = run(program, deck, ["nodes.csv", "outputs.csv"], folder)
        assert code == 0, f"{name}: {text}"
        for change, words in faults:
            changed_nodes, changed_outputs = change([dict(row) for row in nodes], [dict(row) for row in outputs])
            write(folder / "nodes.csv", changed_nodes)
            write(folder / "outputs.csv", changed_outputs)
            code, text = run(program, deck, ["nodes.csv", "outputs.csv"], folder)
            assert code == 1 and words in text, f"{name}, {words!r}: {text}"
            tried += 1
    print(f"{name}: {len(outputs)} states agree, {tried} of {len(faults)} faults named")


def scaled(column, factor):
    def change(nodes, outputs):
        for row in outputs:
            row[column] = repr(float(row[column]) * factor)
        return nodes, outputs

    return change


def principal(column):
    def change(nodes, outputs):
        for row in outputs:
            x = float(row[column])
            row[column] = repr(x - 2 * np.pi * round(x / (2 * np.pi)))
        return nodes, outputs

    return change


def late(column):
    def change(nodes, outputs):
        values = [row[column] for row in outputs]
        for row, value in zip(outputs[1:], values):
            row[column] = value
        return nodes, outputs

    return change


def rotation_in_degrees(nodes, outputs):
    for row in nodes:
        for i in (1, 2, 3):
            row[f"UR{i}"] = repr(float(np.degrees(float(row[f"UR{i}"]))))
    return nodes, outputs


def with_mujoco(program):
    import mujoco

    spun = """<mujoco><option gravity="0 0 -9.81" timestep="0.002"/><worldbody>
      <body name="door"><joint name="pin" type="hinge" axis="0 0 1" damping="0.01"/>
      <geom type="box" size=".3 .02 .5" pos=".3 0 0" mass="2"/></body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(spun)
    data = mujoco.MjData(model)
    data.qvel[0] = 14.0
    nodes, outputs = [], []
    for step in range(1000):
        mujoco.mj_step(model, data)
        if step % 20:
            continue
        mujoco.mj_forward(model, data)
        q, rate = np.array(data.body("door").xquat), float(data.qvel[0])
        nodes.append({"time": data.time, "node": 2, **{f"q{i}": repr(float(q[i])) for i in range(4)}, "VR3": repr(rate)})
        outputs.append({"time": data.time, "element": 7, "CUR1": repr(float(data.qpos[0])), "CVR1": repr(rate)})
    faults = [
        (scaled("CUR1", -1.0), "the sign is the opposite"),
        (scaled("CUR1", 180 / np.pi), "it is in degrees"),
        (principal("CUR1"), "lost from"),
        (late("CVR1"), "one increment late"),
    ]
    check(program, f"MuJoCo {mujoco.__version__}, hinge", HINGE.format(type="HINGE"), nodes, outputs, faults)

    slid = """<mujoco><option gravity="0 0 -9.81"/><worldbody>
      <body name="drawer"><joint name="rail" type="slide" axis="0 0 1" stiffness="90"/>
      <geom type="sphere" size=".1" mass="2"/></body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(slid)
    data = mujoco.MjData(model)
    nodes, outputs = [], []
    for _ in range(200):
        mujoco.mj_step(model, data)
        mujoco.mj_forward(model, data)
        u, v = repr(float(data.qpos[0])), repr(float(data.qvel[0]))
        nodes.append({"time": data.time, "node": 2, "U1": "0", "U2": "0", "U3": u, "V3": v})
        outputs.append({"time": data.time, "element": 7, "CU1": u, "CV1": v})
    faults = [(scaled("CU1", 1000.0), "as mm are of m"), (scaled("CV1", -1.0), "the sign is the opposite")]
    check(program, f"MuJoCo {mujoco.__version__}, slide", HINGE.format(type="TRANSLATOR"), nodes, outputs, faults)
    moment_of_mujoco(program, mujoco)


def moment_of_mujoco(program, mujoco):
    """The moment of a joint's spring and damper, which MuJoCo has on the other side."""
    door = """<mujoco><option gravity="0 0 0" timestep="0.002"/><worldbody>
      <body name="door"><joint name="pin" type="hinge" axis="0 0 1" stiffness="12" damping="0.3"/>
      <geom type="box" size=".3 .02 .5" pos=".3 0 0" mass="2"/></body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(door)
    data = mujoco.MjData(model)
    data.qpos[0] = 1.4
    nodes, outputs = [], []
    for step in range(600):
        mujoco.mj_step(model, data)
        if step % 15:
            continue
        mujoco.mj_forward(model, data)
        nodes.append({"time": data.time, "node": 2, "UR3": repr(float(data.qpos[0])), "VR3": repr(float(data.qvel[0]))})
        outputs.append({"time": data.time, "element": 7, "CTM1": repr(-float(data.qfrc_passive[0]))})
    deck = HINGE.format(type="HINGE").replace("ELSET=C\nHINGE", "ELSET=C, BEHAVIOR=K\nHINGE")
    deck += "*CONNECTOR BEHAVIOR, NAME=K\n*CONNECTOR ELASTICITY, COMPONENT=4\n12.\n*CONNECTOR DAMPING, COMPONENT=4\n0.3\n"
    faults = [(scaled("CTM1", -1.0), "the sign is the opposite: forces on the other side")]
    check(program, f"MuJoCo {mujoco.__version__}, spring and damper", deck, nodes, outputs, faults)


def with_pinocchio(program):
    import pinocchio as pin

    jacobian_of_pinocchio(program, pin)

    model = pin.Model()
    parent = 0
    for joint in (pin.JointModelRX(), pin.JointModelRY(), pin.JointModelRZ()):
        parent = model.addJoint(parent, joint, pin.SE3.Identity(), f"j{parent}")
    data = model.createData()
    nodes, outputs = [], []
    for n in range(200):
        t = 0.05 * n
        q = np.array([1.1 * t, 0.9 * np.sin(1.3 * t), -0.7 * t])
        pin.forwardKinematics(model, data, q)
        quaternion = pin.Quaternion(data.oMi[3].rotation)
        found = [quaternion.w, quaternion.x, quaternion.y, quaternion.z]
        nodes.append({"time": t, "node": 2, **{f"q{i}": repr(float(found[i])) for i in range(4)}})
        outputs.append({"time": t, "element": 7, **{f"CUR{i + 1}": repr(float(q[i])) for i in range(3)}})
    deck = HINGE.format(type="CARDAN").replace("0., 0., 1., 1., 0., 0.", "1., 0., 0., 0., 1., 0.")

    def exchanged(nodes, outputs):
        for row in outputs:
            row["CUR1"], row["CUR3"] = row["CUR3"], row["CUR1"]
        return nodes, outputs

    faults = [(exchanged, "components are exchanged"), (scaled("CUR2", 180 / np.pi), "it is in degrees")]
    check(program, f"Pinocchio {pin.__version__}, three revolutes", deck, nodes, outputs, faults)


def jacobian_of_pinocchio(program, pin):
    """A point that two free bodies share: the velocity of the one relative to the other, in the axes of the first."""
    import scipy.io
    import scipy.sparse

    model = pin.Model()
    joints = [model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), name) for name in ("a", "b")]
    data = model.createData()
    turns = [np.array([0.4, -0.7, 0.3]), np.array([-0.2, 0.5, 1.1])]
    place = np.array([0.3, -0.2, 0.5])
    q = np.concatenate([np.concatenate([place, pin.Quaternion(pin.exp3(turn)).coeffs()]) for turn in turns])
    contact = pin.RigidConstraintModel(
        pin.ContactType.CONTACT_3D, model, joints[0], pin.SE3.Identity(), joints[1], pin.SE3.Identity(), pin.ReferenceFrame.LOCAL
    )
    of_contact = contact.createData()
    pin.computeJointJacobians(model, data, q)
    pin.forwardKinematics(model, data, q)
    contact.calc(model, data, of_contact)
    jacobian = pin.getConstraintJacobian(model, data, contact, of_contact)
    deck = "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n*CONNECTOR SECTION, ELSET=C\nJOIN\n"
    deck += "*ELEMENT, TYPE=ROTARYI, ELSET=R\n8, 1\n9, 2\n*ROTARY INERTIA, ELSET=R\n1., 1., 1.\n"
    nodes = [
        {
            "time": 0,
            "node": n + 1,
            **{f"U{i + 1}": f"{place[i]:.16e}" for i in range(3)},
            **{f"UR{i + 1}": f"{turn[i]:.16e}" for i in range(3)},
        }
        for n, turn in enumerate(turns)
    ]
    with tempfile.TemporaryDirectory() as made:
        folder = pathlib.Path(made)
        write(folder / "nodes.csv", nodes)
        np.save(folder / "j.npy", jacobian)
        scipy.io.mmwrite(folder / "j.mtx", scipy.sparse.coo_matrix(jacobian))
        for kind in ("csr", "csc", "coo"):
            scipy.sparse.save_npz(folder / f"{kind}.npz", getattr(scipy.sparse, f"{kind}_matrix")(jacobian))
        np.savez_compressed(folder / "dense.npz", J=np.asfortranarray(jacobian.astype(np.float32)))
        for file in ("j.npy", "j.mtx", "csr.npz", "csc.npz", "coo.npz", "dense.npz"):
            code, text = run(program, deck, ["nodes.csv", file], folder)
            words = ("every sign is the opposite", "displacements are along the axes of each node")
            assert code == 1 and all(word in text for word in words) and "wrong even so" not in text, f"{file}: {text}"
        spoilt = jacobian.copy()
        spoilt[1, 8] *= 1.001
        np.save(folder / "j.npy", spoilt)
        code, text = run(program, deck, ["nodes.csv", "j.npy"], folder)
        assert code == 1 and "line 2, column 9" in text and "1 entry is wrong even so" in text, text
    print(f"Pinocchio {pin.__version__}, Jacobian of a shared point: its sign and axes named in six formats, a wrong entry too")


def with_exudyn(program):
    import exudyn
    from exudyn.utilities import RotationMatrix2RotationVector, RotationVector2RotationMatrix

    nodes, outputs = [], []
    for n in range(120):
        t = 0.02 * n
        vector = np.array([0.9 * np.sin(t), 1.1 * t, 0.4 * np.cos(2 * t)])
        back = RotationMatrix2RotationVector(RotationVector2RotationMatrix(vector))
        nodes.append({"time": t, "node": 2, **{f"UR{i + 1}": repr(float(vector[i])) for i in range(3)}})
        outputs.append({"time": t, "element": 7, **{f"CPR{i + 1}": f"{float(back[i]):.9e}" for i in range(3)}})
    deck = HINGE.format(type="ROTATION").replace("0., 0., 1., 1., 0., 0.", "1., 0., 0., 0., 1., 0.")
    faults = [(rotation_in_degrees, "the rotations of nodes are in degrees")]
    check(program, f"Exudyn {exudyn.__version__}, rotation vector", deck, nodes, outputs, faults)


def with_calculix(program):
    ccx = shutil.which("ccx")
    if ccx is None:
        raise ImportError("ccx")
    beam = """*NODE, NSET=ALL
1, 0., 0., 0.
2, 1., 0., 0.
3, 2., 0., 0.
*ELEMENT, TYPE=B31, ELSET=E
1, 1, 2
2, 2, 3
*MATERIAL, NAME=M
*ELASTIC
2.1E11, 0.3
*BEAM SECTION, ELSET=E, MATERIAL=M, SECTION=RECT
0.05, 0.04
0., 1., 0.
*BOUNDARY
1, 1, 6
*STEP
*STATIC
*CLOAD
3, 2, 300.
3, 1, 5000.
*NODE PRINT, NSET=ALL
U
*END STEP
"""
    with tempfile.TemporaryDirectory() as made:
        folder = pathlib.Path(made)
        (folder / "beam.inp").write_text(beam)
        subprocess.run([ccx, "beam"], cwd=folder, check=True, capture_output=True)
        printed = (folder / "beam.dat").read_text()
        (folder / "deck.inp").write_text(
            "*NODE\n2, 1., 0., 0.\n3, 2., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 2, 3\n*CONNECTOR SECTION, ELSET=C\nCARTESIAN\n"
        )
        rows = [line.split() for line in printed.splitlines() if line.split()[:1] in (["2"], ["3"])]
        two, three = ([float(x) for x in row[1:4]] for row in rows[:2])
        apart = {f"CU{i + 1}": f"{three[i] - two[i]:.6e}" for i in range(3)}
        write(folder / "outputs.csv", [{"time": 1, "element": 7, **apart}])
        code, text = run(program, (folder / "deck.inp").read_text(), ["beam.dat", "outputs.csv"], folder)
        assert code == 0, f"CalculiX: {text}"
    print("CalculiX, printed displacements: agree")
    springs = "*NODE, NSET=ALL\n1, 0., 0., 0.\n2, 1., 0.5, 0.2\n"
    own = "*NODE\n1, 0., 0., 0.\n2, 1., 0.5, 0.2\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n*CONNECTOR SECTION, ELSET=C, BEHAVIOR=K\nCARTESIAN\n*CONNECTOR BEHAVIOR, NAME=K\n"
    for i, stiffness in enumerate((2000.0, 3100.0, 1700.0), 1):
        springs += f"*ELEMENT, TYPE=SPRING2, ELSET=S{i}\n{i}, 1, 2\n*SPRING, ELSET=S{i}\n{i}, {i}\n{stiffness}\n"
        own += f"*CONNECTOR ELASTICITY, COMPONENT={i}\n{stiffness}\n"
    own += "*BOUNDARY\n1, 1, 6\n2, 1, 3\n"
    springs += "*BOUNDARY\n1, 1, 3\n*STEP\n*STATIC\n*BOUNDARY\n2, 1, 1, 0.01\n2, 2, 2, -0.02\n2, 3, 3, 0.005\n"
    springs += "*NODE PRINT, NSET=ALL\nU, RF\n*END STEP\n"
    with tempfile.TemporaryDirectory() as made:
        folder = pathlib.Path(made)
        (folder / "springs.inp").write_text(springs)
        subprocess.run([ccx, "springs"], cwd=folder, check=True, capture_output=True)
        code, text = run(program, own, ["springs.dat"], folder)
        assert code == 0 and "All 6 numbers agree" in text, f"CalculiX, reactions: {text}"
        printed = (folder / "springs.dat").read_text()
        at = printed.index("\n", printed.index("forces (fx"))
        (folder / "springs.dat").write_text(printed[:at] + printed[at:].replace("E+01", "E+02"))
        code, text = run(program, own, ["springs.dat"], folder)
        assert code == 1, f"CalculiX, reactions: {text}"
    print("CalculiX, printed reactions of springs: agree, a wrong exponent differs")


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--program", default="target/release/pintle")
    program = str(pathlib.Path(arguments.parse_args().program).resolve())
    missing = []
    for peer in (with_mujoco, with_pinocchio, with_exudyn, with_calculix):
        try:
            peer(program)
        except ImportError as error:
            missing.append(f"{peer.__name__.removeprefix('with_')} ({error})")
    print(f"not installed: {', '.join(missing) or 'none'}")


if __name__ == "__main__":
    main()
