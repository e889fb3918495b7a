"""The problems of solve_problems.py in programs that install from PyPI. Each function takes a problem and the length of a step (of
integrators with a tolerance: that), and gives times, positions, speeds.

Joints of MuJoCo, DART and exudyn have friction with a bound that is given: they are given 5. Drake and PyBullet get a box on a floor, whose
bound is μ times its weight, after a second at rest. Pinocchio, SciPy and SUNDIALS have none: theirs is 5 tanh(v/1e-4).
"""

import numpy as np

from solve_problems import END, MASS, MU, WEIGHT

SETTLE = 1.0
SOFT = 1e-4


def mujoco(problem, h):
    import mujoco as mj

    model = mj.MjModel.from_xml_string(f"""
    <mujoco><option timestep="{h}" gravity="0 0 -10" integrator="implicitfast"/><worldbody><body>
      <joint type="slide" axis="1 0 0" stiffness="{problem.spring}" frictionloss="{problem.bound}"/>
      <geom type="box" size=".1 .1 .1" mass="{MASS}" contype="0" conaffinity="0"/>
    </body></worldbody></mujoco>""")
    data = mj.MjData(model)
    out = []
    for i in range(round(END / h)):
        data.qfrc_applied[0] = problem.force(i * h)
        mj.mj_step(model, data)
        out.append((data.time, data.qpos[0], data.qvel[0]))
    return np.array(out).T


def dart(problem, h):
    import dartpy

    world = dartpy.simulation.World() if hasattr(dartpy, "simulation") else dartpy.World()
    dynamics = getattr(dartpy, "dynamics", dartpy)
    world.setTimeStep(h)
    world.setGravity([0, 0, -10])
    skeleton = dynamics.Skeleton("block")
    joint, body = skeleton.createPrismaticJointAndBodyNodePair()
    joint.setAxis([1, 0, 0])
    body.setInertia(dynamics.Inertia(MASS, [0, 0, 0], np.eye(3) * 0.02))
    joint.setSpringStiffness(0, problem.spring)
    joint.setRestPosition(0, 0.0)
    joint.setCoulombFriction(0, problem.bound)
    world.addSkeleton(skeleton)
    out = []
    for i in range(round(END / h)):
        skeleton.setForces([problem.force(i * h)])
        world.step()
        out.append(((i + 1) * h, skeleton.getPositions()[0], skeleton.getVelocities()[0]))
    return np.array(out).T


def exudyn(problem, h):
    import exudyn as exu
    from exudyn.itemInterface import (
        CoordinateSpringDamperExt,
        LoadCoordinate,
        MarkerNodeCoordinate,
        Mass1D,
        Node1D,
        NodePointGround,
        SensorNode,
    )

    container = exu.SystemContainer()
    mbs = container.AddSystem()
    node = mbs.AddNode(Node1D(referenceCoordinates=[0.0]))
    ground = mbs.AddNode(NodePointGround())
    mbs.AddObject(Mass1D(nodeNumber=node, physicsMass=MASS))
    here = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=0))
    there = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
    mbs.AddObject(CoordinateSpringDamperExt(
        markerNumbers=[there, here], stiffness=problem.spring, dynamicFrictionForce=problem.bound, frictionProportionalZone=SOFT,
    ))
    mbs.AddLoad(LoadCoordinate(markerNumber=here, load=1.0, loadUserFunction=lambda mbs, t, load: problem.force(t)))
    sensor = [
        mbs.AddSensor(SensorNode(nodeNumber=node, storeInternal=True, outputVariableType=kind))
        for kind in (exu.OutputVariableType.Coordinates, exu.OutputVariableType.Coordinates_t)
    ]
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = round(END / h)
    settings.timeIntegration.endTime = END
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.9
    settings.timeIntegration.newton.useModifiedNewton = False
    settings.timeIntegration.verboseMode = 0
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = h
    mbs.SolveDynamic(settings)
    x, v = (mbs.GetSensorStoredData(of) for of in sensor)
    return x[:, 0], x[:, 1], v[:, 1]


def drake(problem, h):
    from pydrake.geometry import Box, HalfSpace
    from pydrake.math import RigidTransform
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction, DiscreteContactApproximation
    from pydrake.multibody.tree import PrismaticJoint, SpatialInertia, UnitInertia
    from pydrake.systems.analysis import Simulator
    from pydrake.systems.framework import DiagramBuilder

    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, h)
    plant.set_discrete_contact_approximation(DiscreteContactApproximation.kSap)
    plant.mutable_gravity_field().set_gravity_vector([0, 0, -WEIGHT / MASS])
    small = SpatialInertia(0.0, [0, 0, 0], UnitInertia(0, 0, 0))
    carriage = plant.AddRigidBody("carriage", small)
    box = plant.AddRigidBody("box", SpatialInertia(MASS, [0, 0, 0], UnitInertia(0.01, 0.01, 0.01)))
    along = plant.AddJoint(PrismaticJoint("along", plant.world_frame(), carriage.body_frame(), [1, 0, 0]))
    plant.AddJoint(PrismaticJoint("up", carriage.body_frame(), box.body_frame(), [0, 0, 1]))
    friction = CoulombFriction(max(problem.mu, 0.0), max(problem.mu, 0.0))
    plant.RegisterCollisionGeometry(plant.world_body(), RigidTransform(), HalfSpace(), "floor", friction)
    plant.RegisterCollisionGeometry(box, RigidTransform([0, 0, 0.1]), Box(0.2, 0.2, 0.2), "box", friction)
    actuator = plant.AddJointActuator("push", along)
    plant.Finalize()
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    port = plant.get_actuation_input_port()
    out = []
    steps, settle = round(END / h), round(SETTLE / h)
    for i in range(-settle, steps):
        q, t = along.get_translation(context), max(i, 0) * h
        force = problem.force(t) - problem.spring * q if i >= 0 else 0.0
        port.FixValue(context, [force])
        simulator.AdvanceTo((i + 1 + settle) * h)
        if i >= 0:
            out.append(((i + 1) * h, along.get_translation(context), along.get_translation_rate(context)))
    return np.array(out).T


def pybullet(problem, h):
    import pybullet as p

    client = p.connect(p.DIRECT)
    p.setGravity(0, 0, -WEIGHT / MASS)
    p.setTimeStep(h)
    floor = p.createMultiBody(0, p.createCollisionShape(p.GEOM_PLANE))
    shape = p.createCollisionShape(p.GEOM_BOX, halfExtents=[0.2, 0.2, 0.05])
    box = p.createMultiBody(MASS, shape, basePosition=[0, 0, 0.05])
    # The friction of a contact is the product of both.
    p.changeDynamics(floor, -1, lateralFriction=1.0)
    p.changeDynamics(box, -1, lateralFriction=problem.mu, linearDamping=0, angularDamping=0)
    # What has come to rest is else put to sleep, and held.
    p.setPhysicsEngineParameter(enableFileCaching=0, deterministicOverlappingPairs=1)
    p.changeDynamics(box, -1, activationState=p.ACTIVATION_STATE_DISABLE_SLEEPING)
    out = []
    settle = round(SETTLE / h)
    origin = 0.0
    for i in range(-settle, round(END / h)):
        place = p.getBasePositionAndOrientation(box)[0]
        if i == 0:
            origin = place[0]
        if i >= 0:
            force = problem.force(i * h) - problem.spring * (place[0] - origin)
            p.applyExternalForce(box, -1, [force, 0, 0], place, p.WORLD_FRAME)
        p.stepSimulation()
        if i >= 0:
            x, v = p.getBasePositionAndOrientation(box)[0][0], p.getBaseVelocity(box)[0][0]
            out.append(((i + 1) * h, x - origin, v))
    p.disconnect(client)
    return np.array(out).T


def pinocchio(problem, h):
    import pinocchio as pin

    model = pin.Model()
    model.gravity.linear = np.array([0, 0, -WEIGHT / MASS])
    joint = model.addJoint(0, pin.JointModelPX(), pin.SE3.Identity(), "along")
    model.appendBodyToJoint(joint, pin.Inertia(MASS, np.zeros(3), np.eye(3) * 0.02), pin.SE3.Identity())
    data = model.createData()

    def acceleration(t, x, v):
        force = problem.force(t) - problem.spring * x - problem.bound * np.tanh(v / SOFT)
        return pin.aba(model, data, np.array([x]), np.array([v]), np.array([force]))[0]

    out, x, v = [], 0.0, 0.0
    for i in range(round(END / h)):
        t = i * h
        # Runge and Kutta's of order 4.
        k1, a1 = v, acceleration(t, x, v)
        k2, a2 = v + h / 2 * a1, acceleration(t + h / 2, x + h / 2 * k1, v + h / 2 * a1)
        k3, a3 = v + h / 2 * a2, acceleration(t + h / 2, x + h / 2 * k2, v + h / 2 * a2)
        k4, a4 = v + h * a3, acceleration(t + h, x + h * k3, v + h * a3)
        x, v = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
        if not np.isfinite(x) or abs(x) > 1e6:
            break
        out.append((t + h, x, v))
    return np.array(out).T


def slope(problem):
    def of(t, y):
        force = problem.force(t) - problem.spring * y[0] - problem.bound * np.tanh(y[1] / SOFT)
        return [y[1], force / MASS]

    return of


def scipy(problem, tolerance):
    from scipy.integrate import solve_ivp

    found = solve_ivp(slope(problem), (0, END), [0, 0], method="Radau", rtol=tolerance, atol=tolerance * 1e-3, max_step=0.02)
    return found.t, found.y[0], found.y[1]


def sundials(problem, tolerance):
    from sksundae.cvode import CVODE

    of = slope(problem)

    def right(t, y, out):
        out[:] = of(t, y)

    solver = CVODE(right, rtol=tolerance, atol=tolerance * 1e-3, max_step=0.02, max_num_steps=500_000)
    found = solver.solve(np.array([0, END]), np.zeros(2))
    return found.t, found.y[:, 0], found.y[:, 1]


PROGRAMS = {
    "MuJoCo": (mujoco, "mujoco", "h"),
    "DART": (dart, "dartpy", "h"),
    "exudyn": (exudyn, "exudyn", "h"),
    "Drake": (drake, "drake", "h"),
    "PyBullet": (pybullet, "pybullet", "h"),
    "Pinocchio + RK4": (pinocchio, "pin", "h"),
    "SciPy Radau": (scipy, "scipy", "tolerance"),
    "SUNDIALS CVODE": (sundials, "scikit-sundae", "tolerance"),
}
