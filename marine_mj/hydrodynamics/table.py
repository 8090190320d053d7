"""Layout of the packed table: what stands where in the model's `numeric_data`.

The table is the last `<numeric>` of a marine model. Everything the kernels know travels in it, so
copies, batches, pickles and .mjb files carry it along, and `mujoco.batch.Batch.expand` can vary it
between simulations. All entries are float64; offsets count from the start of the table.
"""

#: Name of the numeric that holds the table.
NAME = "marine_mj_table"
MAGIC = 20261122.0
VERSION = 2.0

# header
H_MAGIC, H_VERSION, H_LENGTH, H_BODIES, H_FIRST_BODY = range(5)
#: Address of the contact sensor in the sensor data plus 1 (0: none), and the forbidden geoms.
H_SENSOR, H_FORBIDDEN, H_FORBIDDEN_DATA = 5, 6, 7

#: Name of the scene's contact sensor, and its values: sum of the normal forces between different
#: vehicles [N], number of contacts of geoms whose own name starts with `FORBIDDEN`, power that the
#: contacts between different vehicles take out of their motion [W], deepest overlap of such a
#: contact's geoms [m].
CONTACT_SENSOR = "marine_mj/contacts"
(S_FORCE, S_FORBIDDEN, S_POWER, S_PENETRATION, CONTACT_VALUES) = range(5)
FORBIDDEN = "forbidden_"
#: Name of the geom that is the sea bed of a scene.
SEA_BED = "sea_bed"

# environment block, right behind the header
E_DENSITY = 8
E_GRAVITY = 9
E_DEPTH = 10  # 0: infinite
E_STRETCHING = 11
E_WAVES = 12  # number of wave components
E_WAVE_DATA = 13  # offset of WAVE_ROWS rows of that many values
E_CREST = 14  # upper bound of |elevation|
E_LEVELS, E_LEVEL_DATA = 15, 16  # current profile: z (n), then velocity (n, 3)
E_KNOTS, E_INTERVAL, E_KNOT_DATA = 17, 18, 19  # current fluctuation (m, 3)
E_WIND_KNOTS, E_WIND_INTERVAL, E_WIND_DATA, E_AIR_DENSITY = 20, 21, 22, 23
#: Geom of the sea bed plus 1 (0: none): its contacts are none of the contact sensor's.
E_BED = 24
FIXED_SIZE = 25

STRETCHING = {"none": 0.0, "constant": 1.0, "wheeler": 2.0}

# rows of the wave data: each a contiguous array over the components
(W_OMEGA, W_K, W_BX, W_BY, W_PHASE, W_AMPLITUDE, W_SPEED, WAVE_ROWS) = range(8)
MAX_WAVES = 500
MAX_STRIPS = 40
#: Longest chain of degrees of freedom from the root to a hydrodynamic body.
MAX_CHAIN = 48

# body record
B_SIZE = 0  # length of the record: the next one starts there
B_BODY, B_ROOT, B_LAST_DOF, B_CHAIN, B_FREE = 1, 2, 3, 4, 5
B_VOLUME, B_CB, B_HALF_HEIGHT = 6, 7, 10
B_FROUDE_KRYLOV, B_CONVECTIVE = 11, 12
#: 1: RAOs stand for the waves. The body feels no orbital motion, and all its linear loads act in
#: level axes turned by the yaw (the seakeeping frame of Fossen 2021, sec. 5.2).
B_SEAKEEPING = 23
B_STRIPS, B_STRIP_X, B_STRIP_DX, B_STRIP_DRAG, B_STRIP_WEIGHT = 13, 14, 15, 16, 18
B_STRIP_MEAN, B_STRIP_SPREAD = 19, 20  # sum w x and sum w (x - mean)^2
B_ELEMENTS, B_ELEMENT_DATA = 21, 22
B_ADDED_MASS, B_LINEAR, B_QUADRATIC = 24, 60, 96
#: Offset of the shelter block of a body near another hull; 0: the water is that of the waves alone.
B_SHELTER = 132
#: Address of the low-frequency states in `data.act` plus 1 (0: none), cut-off frequency of their
#: filter [rad/s], and the distance [m] from the body beyond which they start anew.
B_LOW_FREQUENCY, B_CUTOFF, B_REACH = 133, 134, 135
#: Offset of the block of a floating body that waves act on as if they were long; 0: none.
B_LONG_WAVE = 136
#: Offset of the surface block of a floating body; 0: none.
B_SURFACE = 137
B_FIXED_SIZE = 138

# states of the low-frequency place: 1 once they are set, then six for each of x, y and yaw
LF_SET, LF_X, LF_ORDER, LF_STATES = 0, 1, 6, 19

# surface block: the columns on which a floating body stands (`hydrodynamics.surface`). Height of
# the body origin, roll and pitch afloat, stiffness of a column, its immersed height afloat and its
# whole height, its rise over roll and pitch (COLUMNS, 2), offset of the wave amplitudes averaged
# over the waterplane (components), what the columns lack of the restoring matrix (6, 3), and 1 if
# the surface is that at the low-frequency place, as of the wave force beside it.
COLUMNS = 4
(SF_HEIGHT, SF_ROLL, SF_PITCH, SF_STIFFNESS, SF_DRAUGHT, SF_DEPTH, SF_ARMS) = range(7)
SF_AMPLITUDES, SF_REST, SF_FOLLOWS, SF_SIZE = 14, 15, 33, 34

# shelter block: body of the hull that shelters, numbers of modes, headings and nodes along x, y, z,
# where the nodes' places stand, one axis behind the other, the strengths of the modes in m/s
# (headings, modes, 2, components), the modes (x, y, z, axis, mode), the yaw of the first heading
(SH_HULL, SH_MODES, SH_HEADINGS, SH_NODES) = range(4)
(SH_PLACES, SH_STRENGTHS, SH_FIELD, SH_REFERENCE, SH_SIZE) = range(6, 11)
MAX_SHELTER_MODES = 32

# long-wave block: stiffness of the waterplane (6, 3) on heave, roll and pitch of the surface,
# displaced mass, centre of buoyancy (3), centre of the waterplane (3), its half length and half
# breadth, moments of inertia (3) of the displaced mass, offset of the speeds (2, components):
# horizontal and vertical orbital speed, mean over the draught
(LW_STIFFNESS, LW_MASS, LW_CENTER, LW_PLACE, LW_HALF, LW_INERTIA) = (0, 18, 19, 22, 25, 27)
LW_SPEEDS, LW_SIZE = 30, 31

# elements: force laws that only some bodies have. Each starts with its kind and its length.
RESTORING, EXCITATION, PRESCRIBED, WIND, TANK, MEMORY = 1.0, 2.0, 3.0, 4.0, 5.0, 6.0
DRIFT = 8.0
THRUSTERS = 10.0
EL_KIND, EL_SIZE, EL_DATA = 0, 1, 2
#: Modes of the drift element.
DRIFT_MODES = {"mean": 0.0, "slow": 1.0}
# wind: areas (front, lateral), length, height of the lateral centroid above the origin, share of
# the wind at 10 m that blows there, law, 1 with a roll coefficient of its own; the law's numbers
(WD_FRONT, WD_LATERAL, WD_LENGTH, WD_HEIGHT, WD_PROFILE, WD_LAW, WD_ROLL, WD_DATA) = range(8)
WIND_CONSTANT, WIND_TABLE, WIND_BLENDERMANN = 0.0, 1.0, 2.0
# wind table: number of rows, then gamma (rising from 0 to 2 pi), C_X, C_Y, C_N, C_K of each (FRD)
WT_ROWS, WT_DATA, WT_COLUMNS = 0, 1, 5
# thrusters: their number, then a row of each
TH_COUNT, TH_ROWS = 0, 1
#: Row of a thruster: address of its state; 1: in `act`, 0: in `ctrl`; force per unit; limits of the
#: force; loss per square root of the force and speed; place and axis (FLU).
(TH_ADDRESS, TH_LAG, TH_GAIN, TH_LOW, TH_HIGH, TH_LOSS, TH_PLACE) = range(7)
TH_AXIS, TH_SIZE = 9, 12
# memory: address of the states in data.act, numbers of poles and of groups; then, over the poles,
# Re and Im of lambda and of 1 / lambda; then the groups
MM_ADDRESS, MM_POLES, MM_GROUPS, MM_DATA = 0, 1, 2, 3
# group: numbers of degrees of freedom and of poles, its first pole, its degrees of freedom; then
# Re r and Im r over the poles, for every driving and every answering degree of freedom
MG_DOFS, MG_POLES, MG_FIRST, MG_DOF, MG_RESIDUES = 0, 1, 2, 3, 9
#: Most poles of one body.
MAX_POLES = 48
#: Pressure on the wetted panels of a hull mesh.
PANELS = 7.0
# its parameters: vertices (n) and triangles (m), then where they stand
P_VERTICES, P_TRIANGLES = 0, 1
P_VERTEX_DATA = 2  # offset of x (n), y (n), z (n), and again as (n, 3); body axes
P_TRIANGLE_DATA = 3  # offset of rows: three vertex numbers, area times outward normal (3)
P_WAVES = 4  # 1: with the pressure of the incident waves
P_COUNTS = 5  # Chebyshev nodes along, across and downwards (3); 0: summed at every vertex
P_NODES = 8  # their places in [-1, 1] (3, MAX_NODES)
P_TRANSFORMS = 56  # from values at the nodes to coefficients (3, MAX_NODES, MAX_NODES)
#: Number of components, from the longest on, that the nodes serve; the others are summed at every
#: vertex.
P_LONG = 824
P_SIZE = 825
MAX_NODES = 16
#: Most components that are summed at every vertex beside the nodes.
MAX_SHORT = 32
PANEL_COLUMNS = 6
MAX_HULL_VERTICES = 1024
MAX_HULL_TRIANGLES = 2048

#: What the wrench on a body is reported by, in the order of the kernel's accumulators.
CAUSES = (
    *("added_mass", "damping", "restoring", "waves", "wind", "ballast", "prescribed"),
    *("radiation", "thrust_loss"),
)
C_ADDED_MASS, C_DAMPING, C_RESTORING, C_WAVES, C_WIND, C_BALLAST, C_PRESCRIBED = range(7)
C_RADIATION, C_THRUST_LOSS = 7, 8
#: Inertia matrices beside the rigid body's: added mass, ballast, prescribed motion.
M_ADDED, M_BALLAST, M_PRESCRIBED, INERTIAS = 0, 1, 2, 3
#: Length of the report of one body: wrenches by cause, then the inertia matrices.
REPORT_SIZE = 6 * len(CAUSES) + 36 * INERTIAS

# laws of user activations (first entry of actuator_dynprm)
RATE_LIMITED_LAG = 1.0
RADIATION_MEMORY = 2.0  # second entry: number of the body's record
LOW_FREQUENCY = 3.0  # second entry: number of the body's record
