"""The scenes of restart.py: in each something goes on at its checkpoint, in the middle of its 60 frames."""

PILE = """
    time: {frame: 0.016, frames: 60}
    output: {every: 20, checkpoint_every: 30}
    gravity: [{sine: {amplitude: 2, frequency: 1.5}}, 0, -9.81]
    materials: {stone: {friction: [[0.2, 0.6], [0.7, 0.1]], stiction: 0.3, adhesion: 2, surface_energy: 1,
                        stiffness: 2.0e+5, damping_ratio: 0.3}}
    bodies:
      - container: {size: [1, 1]}
      - shape: {box: {size: [0.2, 0.9, 0.2]}}
        motion: kinematic
        position: [-0.3, 0, 0.12]
        path: [{sine: {amplitude: 0.2, frequency: 0.8}}, 0, [[0.3, 0], [0.7, 0.1]]]
        surface_velocity: [0, {expression: "t > 0.2 ? sin(5 * t) : 0"}, 0]
      - pile:
          count: 60
          columns: [3, 3]
          mix:
            - {shape: {sphere: {radius: 0.08}}, scale: [0.6, 1.4]}
            - {shape: {box: {size: [0.2, 0.15, 0.1]}}, scale: [0.5, 1.2]}
        density: 2600
        position: [0, 0, 0.3]
        velocity: [0, 0, -3]
        force: [0, {sine: {amplitude: 4, frequency: 2}}, 0]
        torque: [0, 0, [[0.3, 0], [0.6, 0.2]]]
"""

CLOTH = """
    time: {frame: 0.016, frames: 60}
    output: {every: 20, checkpoint_every: 30}
    solver: {warm_start: 0.5, iterations: 12}
    bodies:
      - shape: {sphere: {radius: 0.2}}
        motion: fixed
      - shape: {box: {size: [0.2, 0.2, 0.2]}}
        mass: 0.2
        position: [0, 0, 0.6]
    cloths:
      - grid: {size: [0.9, 0.9], nodes: [18, 18]}
        mass: 0.5
        thickness: 0.05
        links: {stiffness: 3000, damping: 0.01}
        bending: {model: dihedral, stiffness: 0.01}
        position: [0, 0, 0.35]
        pins: [{node: [0, 0]}, {node: [17, 17], release: 0.7}]
    threads:
      - {points: [[-0.5, 0, 0.8], [0.5, 0, 0.8]], segments: 30, radius: 0.02, mass: 0.1}
"""

# Bodies that come in and slide down through a cell that repeats itself, over a bump at its border, and a probe of their flow.
PERIODIC = """
    time: {frame: 0.016, frames: 60, substeps: 2}
    output: {every: 20, checkpoint_every: 30}
    periodic: {x: [0, 0.6], y: [-0.3, 0.3]}
    gravity: [4, 1, -9]
    bodies:
      - {shape: {plane: {normal: [0, 0, 1]}}}
      - {shape: {sphere: {radius: 0.05}}, motion: fixed, position: [0.01, 0, 0]}
      - {name: balls, lattice: {count: 24, columns: [4, 4], spacing: [0.15, 0.15, 0.12], height: 0.07, jitter: 0.02},
         shape: {sphere: {radius: 0.05}}, mass: 1}
      - {name: boxes, inlet: {count: 20, rate: 30, box: {low: [-0.2, -0.2, 0.4], high: [0.2, 0.2, 0.5]},
         mix: [{shape: {box: {size: [0.08, 0.07, 0.06]}}}]}, density: 2000}
      - {name: links, shape: {box: {size: [0.04, 0.03, 0.03]}}, mass: 0.2,
         chain: {count: 6, from: [0.45, 0.2, 0.3], to: [0.75, 0.2, 0.3], joint: {type: ball}}}
    probes:
      - {name: flux, flow: {point: [0.3, 0, 0], normal: [1, 0, 0]}}
"""

# A cloth in the wind, held by a body that turns and tied to one that swings, until they are let go after the checkpoint.
TIED = """
    time: {frame: 0.016, frames: 60}
    output: {every: 20, checkpoint_every: 30}
    wind: [1, 0, 2]
    bodies:
      - {name: crank, shape: {box: {size: [0.1, 0.1, 0.1]}}, motion: kinematic, position: [0.5, -0.5, 0.4], angular_velocity: [1, 0, 2]}
      - {name: weight, shape: {sphere: {radius: 0.05}}, mass: 0.1, position: [-0.5, 0.5, 0.4]}
    cloths:
      - grid: {size: [0.9, 0.9], nodes: [18, 18]}
        mass: 0.5
        thickness: 0.02
        drag: 1
        pressure: {sine: {amplitude: 1, frequency: 2}}
        links: {stiffness: 3000, damping: 0.01}
        position: [0, 0, 0.35]
        pins: [{node: [0, 0]}, {node: [17, 0], to: crank, release: 0.8}, {node: [0, 17], to: weight, release: 0.9}]
"""

# A chain that swings into a box, and a motor that has not reached its speed by then.
JOINTED = """
    time: {frame: 0.016, frames: 60}
    output: {every: 20, checkpoint_every: 30}
    solver: {iterations: 12}
    bodies:
      - {name: box, shape: {box: {size: [0.3, 0.3, 0.3]}}, mass: 3, position: [0.2, 0, -1.2]}
      - {name: wheel, shape: {sphere: {radius: 0.3}}, mass: 5, position: [0, 3, 0]}
      - shape: {box: {size: [0.09, 0.03, 0.02]}}
        mass: 0.1
        chain: {count: 12, from: [0, 0, 0], to: [0.8, 0, -0.8], held: start, joint: {type: ball}, ball: {radius: 0.1, mass: 2}}
    joints:
      - {type: hinge, bodies: [wheel, world], anchor: [0, 3, 0], axis: [0, 1, 0], motor: {speed: [[0.2, 40], [0.8, -20]], max_torque: 5}, friction: 1}
      - {type: slider, bodies: [box, world], anchor: [0, 0, -1.2], axis: [1, 0, 0], limits: [-1, 0.1]}
"""

# A motor that turns a wheel, and by it, through several turns, another one and a rack, all of which springs hold back; on the rack
# lies a ball, through which another one falls.
GEARED = """
    time: {frame: 0.016, frames: 60}
    output: {every: 20, checkpoint_every: 30}
    solver: {iterations: 30}
    bodies:
      - {name: rack, shape: {box: {size: [2, 0.3, 0.1]}}, mass: 3, position: [0, 0, 0], inertia: [0.1, 1, 1, 0.01, 0, 0.02], centre_of_mass: [0.1, 0, 0]}
      - {name: pinion, shape: {cylinder: {radius: 0.3, length: 0.1}}, mass: 5, position: [0, 3, 0]}
      - {name: wheel, shape: {cylinder: {radius: 0.3, length: 0.1}}, mass: 5, position: [0, 5, 0]}
      - {name: load, shape: {sphere: {radius: 0.1}}, mass: 1, position: [0.2, 0, 0.15]}
      - {name: ghost, shape: {sphere: {radius: 0.1}}, mass: 1, position: [0.2, 0, 0.4], collide: {with: []}}
    joints:
      - {name: axle, type: hinge, bodies: [pinion, world], anchor: [0, 3, 0], axis: [0, 0, 1], motor: {speed: [[0.2, 40], [0.8, -20]], max_torque: 50}}
      - {name: shaft, type: hinge, bodies: [wheel, world], anchor: [0, 5, 0], axis: [0, 0, 1], spring: {damping: 0.1}}
      - {name: guide, type: slider, bodies: [rack, world], anchor: [0, 0, 0], axis: [1, 0, 0], spring: {stiffness: 20, damping: 2, rest: 0.1}}
    couplings:
      - {joints: [shaft, axle], ratio: -0.7}
      - {joints: [guide, axle], ratio: 0.01}
"""

# Grains that plates close on, and have begun to press at the checkpoint.
TRIAXIAL = """
    time: {frame: 0.016, frames: 60, substeps: 2}
    output: {every: 20, checkpoint_every: 30}
    solver: {iterations: 30}
    bodies:
      - name: cell
        triaxial: {size: [0.4, 0.4, 0.4], thickness: 0.05, density: 500, x: {pressure: 3000, closing_speed: 0.1},
                   y: {pressure: 3000, closing_speed: 0.1}, z: {pressure: [[0, 4000], [0.8, 9000]], closing_speed: 0.1}}
      - lattice: {count: 125, columns: [5, 5], spacing: [0.078, 0.078, 0.078], height: 0.04, jitter: 0.002}
        shape: {sphere: {radius: 0.036}}
        density: 2000
    probes: [{name: sample, cell: cell}]
"""

# A wall in mortar, of which some has broken when a ball hits it and more does later; a load on a rope that is cut.
BREAKING = """
    time: {frame: 0.016, frames: 60, substeps: 2}
    output: {every: 20, checkpoint_every: 30, joints: true}
    solver: {iterations: 30}
    bodies:
      - {name: footing, shape: {box: {size: [4, 1, 0.2]}}, motion: fixed, position: [0, 0, -0.1]}
      - {name: bricks, wall: {bricks: 4, courses: 4, gap: 0}, shape: {box: {size: [0.4, 0.2, 0.2]}}, density: 1800}
      - {name: early, shape: {sphere: {radius: 0.2}}, mass: 60, position: [0.3, -0.8, 0.5], velocity: [0, 5, 0]}
      - {name: late, shape: {sphere: {radius: 0.2}}, mass: 200, position: [-0.3, -4.1, 2.7], velocity: [0, 6, 0]}
      - {name: load, shape: {sphere: {radius: 0.1}}, mass: 2, position: [1.5, 0, 2]}
    joints: [{name: string, type: rope, bodies: [load, world], points: [[1.5, 0, 2.1], [1.5, 0, 3]]}]
    bonds: [{name: mortar, bodies: [footing, bricks], strength: {force: 4000, torque: 300}}]
    events: [{do: release, joints: string, when: {time: 0.3}}]
"""
