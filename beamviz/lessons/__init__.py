"""The lessons, in the order in which they build on each other: LESSONS, lesson(name)."""

import textwrap

from beamviz.beam import Beam
from beamviz.checks import check_choice
from beamviz.lessons import model
from beamviz.lessons.model import BARE, MIDDLE, TIP, Lesson, frequency, labelled
from beamviz.scene import Scene
from beamviz.solver import solve

INWARD = Beam(delta=-1)
FOLDED = INWARD.replace(gamma=4)
LAGGING = Beam(spin_up=10)
STABLE = {"state": "stable"}
ON_A_HUB = Beam(delta=1)

LESSONS = (
    Lesson(
        name="stiffening",
        title="Spinning makes it stiffer",
        question="Only the speed of rotation changes. Why does the beam vibrate faster?",
        guesses=(
            "The beam gets lighter.",
            "It is pulled tight, like a string.",
            "Its material gets harder.",
        ),
        right=1,
        scene=Scene.of(plane="flapwise", mode=1),
        do="Turn the orange wheel on the hub, or drag **speed γ**, slowly from 0 up to 10.",
        see="The frequency ω of B1, the slowest mode, rises with the speed.",
        meaning="Every piece of the rotating beam pulls outward, so the beam is under tension. A"
        " taut string is harder to push aside than a slack one, and swings back faster:"
        " *centrifugal stiffening*.",
        fact="At γ = 10, ω of B1 is {:.3f}; at rest it is {:.3f}.",
        compute_fact=lambda: (frequency(BARE.replace(gamma=10), plane="flapwise"), frequency(BARE)),
        task="Find the speed at which B1 is twice as fast as at rest.",
        gauge=lambda s: s.frequencies[0] / frequency(s.beam.replace(gamma=0)),
        reading="B1 is {:.2f} times as fast as at rest",
        level=2,
    ),
    Lesson(
        name="two-planes",
        title="Up and down, or side to side",
        question="A rotating beam is as stiff up and down as side to side, in the plane of"
        " rotation. Which vibration is faster?",
        guesses=("Up and down.", "Side to side.", "Both are equally fast."),
        right=0,
        scene=Scene.of(gamma=10, mode=1),
        do="Switch **plane** between flapwise (up and down) and chordwise (side to side).",
        see="B1 is slower side to side, as if the beam had become softer.",
        meaning="A piece displaced in the plane of rotation is pulled radially outward, which is a"
        " little further aside: the centrifugal force acts against the stiffness. Up and down it"
        " has no such component. This *spin softening* takes exactly γ² from ω².",
        fact="At γ = 10, ω² of B1 is {:.3f} up and down, {:.3f} side to side: {:.3f} less.",
        compute_fact=lambda: (
            up := frequency(BARE.replace(gamma=10), plane="flapwise") ** 2,
            aside := frequency(BARE.replace(gamma=10)) ** 2,
            up - aside,
        ),
        task="Find the speed at which B1 is twice as fast up and down as side to side.",
        gauge=lambda s: frequency(s.beam, plane="flapwise") / frequency(s.beam),
        reading="it is {:.2f} times as fast",
        level=2,
        free=("plane",),
    ),
    Lesson(
        name="moving-mass",
        title="A mass moves along the beam",
        question="The mass weighs as much as the beam. Does it matter where it sits?",
        guesses=(
            "No, it weighs the same everywhere.",
            "Yes, most at the tip.",
            "Yes, most at the hub.",
        ),
        right=1,
        scene=Scene.of(alpha=1, beta=1, mode=1, over="beta"),
        do="Take the mass in the scene and slide it from the tip to the hub, or drag **position β**"
        " from 1 to 0.",
        see="The frequency of B1: most of the change happens in the outer half.",
        meaning="A mass lowers a frequency by taking part in the motion. The tip moves most; near"
        " the hub there is hardly any motion, and the mass has hardly any effect. What counts is"
        " mass times displacement squared, its share of the *modal mass*.",
        fact="ω of B1 is {:.4f} with the mass at the tip and {:.4f} with it at the hub.",
        compute_fact=lambda: (frequency(TIP), frequency(TIP.replace(beta=0))),
        task="Find the position at which the mass slows B1 to two thirds (0.667).",
        number="beta",
        within=0.01,
        gauge=lambda s: labelled(s, "B1") / frequency(s.beam.replace(alpha=0)),
        reading="B1 is {:.3f} times what it is without the mass",
        level=2 / 3,
    ),
    Lesson(
        name="nodes",
        title="The mass that changes nothing",
        question="Is there a place on the beam, away from the hub, where even a heavy mass has no"
        " effect?",
        guesses=("No, a mass always slows the beam.", "Yes, there is such a place."),
        right=1,
        scene=Scene.of(alpha=1, beta=0.5, mode=2, over="beta"),
        do="The picture shows B2. Slide the mass along the beam, or drag **position β**, then drag"
        " **mass α**, and watch ω of B2.",
        see="The pink ring: there the beam does not move. With the mass at the ring, making it"
        " heavier no longer changes B2.",
        meaning="In each mode, some places of the beam do not move at all, the *vibration nodes*. A"
        " mass that does not move exerts no force, so it does not change this mode. Other modes"
        " have their nodes elsewhere, and do change.",
        fact="The bare beam has ω = {:.4f} and its node at {:.5f}. With a mass five times its own"
        " there, ω is {:.4f}.",
        compute_fact=lambda: (
            frequency(BARE, "B2"),
            (node := solve(BARE).nodes[1][0]),
            frequency(Beam(alpha=5, beta=node), "B2"),
        ),
        task="Put the mass where it does not change B2.",
        number="beta",
        within=0.006,
        answer_in_fact=1,
        gauge=lambda s: 100 * (labelled(s, "B2") / frequency(s.beam.replace(alpha=0), "B2") - 1),
        reading="the mass changes B2 by {:+z.2f} %",
        free=("alpha",),
    ),
    Lesson(
        name="unknown-mass",
        title="Weigh what you cannot reach",
        question="A body is hidden in a beam at rest. You can only tap the beam and listen: five"
        " frequencies. Do they tell how heavy the body is, and where?",
        guesses=(
            "Two frequencies are enough: two unknowns.",
            "Five are needed to be sure.",
            "Frequencies cannot tell.",
        ),
        right=1,
        scene=Scene.of(MIDDLE, mode=1),
        do="Measured were ω = 2.197, 21.74 and 49.86 of B1, B2 and B3, 67.97 of S1 and 104.7 of B4."
        " Drag **mass α** and **position β** until the modes have these frequencies.",
        see="With B1 and B2 alone you may end at more than one place: a lighter mass further out is"
        " as slow. The others decide.",
        meaning="Each frequency leaves a curve of masses over places, and two curves may meet more"
        " than once. More data than unknowns is what makes an answer certain, and shows how good it"
        " is: that is *least squares*. The tab Adjust does it: write the modes and frequencies"
        " there, and press the button.",
        fact="The computer finds α = {:.3f} at β = {:.3f}. B1 and B2 alone are met by α = {:.3f} at"
        " β = {:.3f}, too.",
        compute_fact=model.hidden_mass,
        task="Find the mass and its position, by hand or by the computer.",
        number="beta",
        within=0.01,
        answer_in_fact=1,
        gauge=model.misfit,
        at_most=1.2,
        reading="the five frequencies are {:.2f} % from those measured",
        free=("alpha",),
    ),
    Lesson(
        name="mode-shift",
        title="Which one is the third mode?",
        question="Modes are numbered by frequency. Does the third always have the same shape?",
        guesses=("Yes, always.", "No, the order can change."),
        right=1,
        scene=Scene.of(alpha=1, beta=1, mode=4, over="alpha"),
        do="Drag **mass α** from 1 to 2. The picture shows mode 4: the beam stretches.",
        see="S1 (stretching) and B3 (bending) change places in the order of frequencies.",
        meaning="A mass at the tip lowers S1, which moves the tip most, and hardly changes B3,"
        " which leaves the tip almost at rest. Labels (S1, B3) belong to the shape, numbers only to"
        " the order of the frequencies: the *mode shift*.",
        fact="S1 is mode {:.0f} at α = 1 and mode {:.0f} at α = 2; the two are equal at"
        " α = {:.3f}.",
        compute_fact=lambda: (
            *(solve(TIP.replace(alpha=alpha)).labels.index("S1") + 1 for alpha in (1, 2)),
            model.crossing("alpha", 3).at,
        ),
        task="Find the mass at which S1 and B3 are equally fast.",
        number="alpha",
        within=0.02,
        answer_in_fact=2,
        gauge=model.difference,
        reading="S1 and B3 are {:.2f} apart",
    ),
    Lesson(
        name="crossing",
        title="Meeting without touching",
        question="Two frequencies run into each other as the speed grows. What happens there?",
        guesses=(
            "They pass through each other.",
            "They turn away from each other.",
            "The beam becomes unstable.",
        ),
        right=0,
        scene=Scene.of(alpha=1, beta=1, gamma=2, mode=4),
        do="In **Frequencies** every line is one mode (a *locus*). Drag **speed γ** through the"
        " ring where S1 crosses B3.",
        see="Both lines run straight on, and each keeps its shape: one stretches, one bends."
        " The scene shows the mode of the 4th frequency: S1 before the ring, B3 after it.",
        meaning="Without Coriolis forces, stretching and bending of a straight beam are uncoupled,"
        " so the two lines pass through each other: a *crossing*. A chart that only sorts the"
        " frequencies draws two curves that turn away from each other, and is easily misread.",
        fact="They cross at γ = {:.4f}, both with ω = {:.3f}: gap {:.0f}.",
        compute_fact=lambda: (
            (event := model.crossing("gamma", 10)).at,
            event.frequency,
            event.gap,
        ),
        task="Find the speed at which B3 crosses S1.",
        within=0.05,
        gauge=model.difference,
        reading="S1 and B3 are {:.2f} apart",
    ),
    Lesson(
        name="veering",
        title="The same two modes, now they avoid each other",
        question="The last lesson left out one force. What does it do to the crossing?",
        guesses=("Nothing.", "The lines avoid each other.", "They cross at another speed."),
        right=1,
        scene=Scene.of(alpha=1, beta=1, gamma=2, coriolis=True, mode=4),
        do="**Coriolis** is on now. In **Frequencies**, click the ◆ where S1 and B3 come closest,"
        " then open **Veering** and drag Coriolis to 0 % and back to 100 %.",
        see="Magnified, the lines bend away before they touch: the gap opens with the force."
        " Stretching continues as bending, and the other way round.",
        meaning="A particle that moves along a rotating beam is pushed across it, as on a"
        " merry-go-round: the *Coriolis force*. It couples stretching and bending, and frequencies"
        " of coupled modes do not cross. The modes exchange their shapes instead: *veering*.",
        fact="The gap never falls below {:.3f}, at γ = {:.3f}.",
        compute_fact=lambda: ((event := model.crossing("gamma", 10, coriolis=True)).gap, event.at),
        task="Find the speed at which modes 3 and 4 come closest.",
        answer_in_fact=1,
        gauge=lambda s: s.frequencies[3] - s.frequencies[2],
        reading="modes 3 and 4 are {:.3f} apart",
    ),
    Lesson(
        name="flap-and-lag",
        title="What does a pitch do where flap meets lag?",
        question="A flat beam is softer up and down (flap) than side to side (lag), but spinning"
        " stiffens flap more. At some speed the two are equally fast. What changes there if the"
        " beam is pitched by a few degrees?",
        guesses=(
            "Nothing: they still meet.",
            "They meet at another speed.",
            "They no longer meet.",
        ),
        right=2,
        scene=Scene.of(flap=0.25, gamma=3, plane="both", mode=1, tip_path=True),
        do="In **Frequencies**, F1 crosses L1 near γ = 3. Drag **pitch θ** slowly from 0 to 20.",
        see="The gap between modes 1 and 2 opens as you drag. Each of the two now moves up and"
        " down and side to side at once, along the orange path of its tip.",
        meaning="Without a pitch the two planes are independent, and two independent frequencies"
        " may be equal. A pitched section bends most easily along a slanted line, so flap and lag"
        " share a stiffness: they are coupled, and coupled modes do not cross. It is a *veering*"
        " without any Coriolis force; the smaller the pitch, the sharper.",
        fact="Without a pitch F1 and L1 cross at γ = {:.4f}. Pitched by 5° they keep {:.3f} apart"
        " at least, at γ = {:.3f}, and at γ = 3 they are 0.5 apart at a pitch of {:.3f}°.",
        compute_fact=model.flap_and_lag,
        task="At γ = 3, find the pitch above 0 at which modes 1 and 2 are 0.5 apart.",
        number="pitch",
        within=0.3,
        answer_in_fact=3,
        gauge=lambda s: s.frequencies[1] - s.frequencies[0],
        reading="modes 1 and 2 are {:.3f} apart",
    ),
    Lesson(
        name="twist",
        title="Which way does a twisted blade bend?",
        question="A flat beam at rest vibrates either up and down or side to side. What does it do"
        " after it is twisted from root to tip, like a blade?",
        guesses=(
            "Either up and down or side to side, as before.",
            "Both at once, in every mode.",
        ),
        right=1,
        scene=Scene.of(flap=1 / 16, plane="both", mode=2, tip_path=True),
        do="Drag **twist φ** from 0 up to 60 and look at modes 1 to 3.",
        see="The tip moves along a slanted line, drawn in orange. Mode 1 stays mostly up and down;"
        " mode 3 takes more and more of the motion side to side.",
        meaning="Every section bends most easily across its flat side, and that direction turns"
        " along a twisted beam. No mode can keep to one plane: bending is *coupled*, at rest and"
        " without any force. The share of its kinetic energy in each plane says which of the two a"
        " mode is more of.",
        fact="Twisted by 60°, modes 1, 2 and 3 have {:.1%}, {:.1%} and {:.1%} of their kinetic"
        " energy in the plane of rotation; untwisted 0, 100 and 0 %. Mode 3 has a quarter at"
        " {:.3f}°.",
        compute_fact=model.twisted_shares,
        task="Find the twist above 0 at which a quarter of the energy of mode 3 is in the plane.",
        number="twist",
        within=0.5,
        answer_in_fact=3,
        gauge=lambda s: 100 * s.in_plane_fraction[2],
        reading="mode 3 has {:.1f} % of its energy in the plane",
    ),
    Lesson(
        name="resonance",
        title="Excited three times per revolution",
        question="Wind and gravity load a blade at the same places in every revolution. At which"
        " speed is that dangerous?",
        guesses=(
            "At every high speed.",
            "Where a multiple of the speed equals a frequency.",
            "At none: the blade is stiff enough.",
        ),
        right=1,
        scene=Scene.of(gamma=5, mode=2, per_rev=(1, 2, 3)),
        do="Open the tab **Frequencies** and drag the line of the beam to where the dashed line 3 ×"
        " intersects the locus of B2.",
        see="The dashed lines 1 ×, 2 ×, 3 × speed: the frequencies of forces that repeat one, two,"
        " three times per revolution.",
        meaning="A force at a mode's own frequency adds energy in every cycle: a *resonance*. A"
        " chart of loci with these lines is a *Campbell diagram*; machines are kept away from its"
        " intersections, or run through them fast.",
        fact="Side to side (chordwise), 3γ equals the frequency of B2 at γ = {:.3f}; 1γ equals that"
        " of B1 at γ = {:.3f}.",
        compute_fact=lambda: (model.resonance(3, "B2"), model.resonance(1, "B1")),
        task="Find the speed at which a force three times per revolution excites B2.",
        gauge=lambda s: 3 * s.beam.gamma / labelled(s, "B2"),
        reading="the frequency of the force is {:.3f} times that of B2",
    ),
    Lesson(
        name="paradox",
        title="A theory that predicts collapse",
        question="In the 1980s respected programs predicted that a spinning beam collapses."
        " Does it?",
        guesses=(
            "Yes, the centrifugal force pulls it aside.",
            "No, the programs left something out.",
        ),
        right=1,
        scene=Scene.of(gamma=2, method="zoac", mode=1),
        do="The **method** is zoac, the classical linear theory. Raise **speed γ** beyond 4. Then"
        " set it to auto.",
        see="B1 falls to zero and the page says: divergence. With auto the beam stays stable.",
        meaning="The linear theory neglects that bending draws the tip inward, against the"
        " centrifugal force. So it has the softening of the second lesson without the"
        " stiffening of the first. Kane, Ryan and Banerjee showed it in 1987: *Kane's paradox*.",
        fact="In the linear theory ω of B1 is 0 at γ = {:.3f}; in fact it is {:.3f} there.",
        compute_fact=lambda: (
            (speed := model.first_unstable(BARE, 5, method="zoac")),
            frequency(BARE.replace(gamma=speed)),
        ),
        task="With zoac, find the speed at which the beam becomes unstable.",
        within=0.05,
        gauge=lambda s: s.omega_squared[0],
        reading="ω² of B1 is {:.2f}",
    ),
    Lesson(
        name="spin-up",
        title="The spin-up of 1987",
        question="A robot arm is spun up from rest, smoothly, in fifteen seconds. How does its tip"
        " move meanwhile?",
        guesses=(
            "It lags further and further, until the arm breaks.",
            "It lags at first, and comes back.",
            "It runs ahead of the arm.",
        ),
        right=1,
        scene=Scene.of(model.KANE, mode=1),
        motion={
            "pull": 0.0,
            "hub": "smooth",
            "within": model.SPIN_UP_TIME,
            "until": 24.0,
            "damping": 0.0,
            "unstiffened": True,
        },
        do="The tab **Motion** computes it: the arm in colours, and pale beside it the theory"
        " without stiffening. Play it, then drag the line through the chart. Repeat it with"
        " **speed γ** 3.",
        see="Both lag, and agree within 2 % until t = 4. Then the arm is straightened and swings a"
        " little; the pale one never comes back. At γ = 3 both come back.",
        meaning="While the arm speeds up, its inertia bends it backwards. As it turns faster, the"
        " centrifugal force pulls it straight: *dynamic stiffening*. The theory that leaves this"
        " out softens instead, until nothing holds the arm. Programs of the time did so; in 1987"
        " Kane, Ryan and Banerjee showed with this arm that they were wrong.",
        fact="The tip lags by {:.5f} L at most, at t = {:.2f}: 0.574 m for the arm of 10 m. Without"
        " stiffening it lags by its whole length at t = {:.2f}.",
        compute_fact=model.spin_up,
        task="Find the speed from which on the theory without stiffening diverges.",
        within=0.05,
        gauge=lambda s: solve(s.beam, method="zoac").omega_squared[0],
        reading="without stiffening, ω² of B1 is {:.2f}",
        level=0,
    ),
    Lesson(
        name="hear-the-modes",
        title="Hear the modes",
        question="You pluck the beam and listen to its tip. Which of its modes do you hear?",
        guesses=(
            "Only the slowest.",
            "All of them, always equally loud.",
            "It depends on where you pluck.",
        ),
        right=2,
        scene=Scene.of(mode=2),
        motion={"pull": 0.5, "damping": 0.0},
        do="The tab **Motion** shows how strongly the tip moves at each frequency, its spectrum."
        " Set **pull at** to 0.5, the middle, and compare.",
        see="Plucked at the tip, the spectrum has a peak at each of B1, B2, B3. Plucked in the"
        " middle, B2 is louder relative to B1, and the peak at B3 is far smaller.",
        meaning="A force acts only on a mode that moves where it pulls. B3 has a *node*, a"
        " place without motion, at x = 0.504: a pull at 0.5 hardly excites it. The spectrum tells"
        " which modes a motion consists of, without seeing it: that is how *modal analysis* finds"
        " the modes of real machines.",
        fact="Plucked at the tip, B2 is {:.2f} % as loud as B1; plucked at its node, x = {:.5f},"
        " {:.4f} %.",
        compute_fact=lambda: (
            100 * model.heard("B2", 1.0),
            (node := float(solve(BARE).nodes[1][0])),
            100 * model.heard("B2", node),
        ),
        task="Pull the beam where B2 is not heard.",
        number="pull_at",
        within=0.006,
        answer_in_fact=1,
        gauge=lambda s, x: 100 * model.strength(s, "B2", x),
        reading="B2 is {:.2f} % as loud as B1",
    ),
    Lesson(
        name="buckling",
        title="Pointing inward",
        question="Clamp the beam to a rim so that it points at the axis. What does rotation do to"
        " it now?",
        guesses=(
            "It stiffens the beam, as before.",
            "It compresses the beam, until the beam gives way.",
            "Nothing.",
        ),
        right=1,
        scene=Scene.of(gamma=1, delta=-1, mode=1),
        do="Hub δ is −1: the tip touches the axis. Raise **speed γ** from 1 to 3.5.",
        see="B1 falls instead of rising, and reaches zero. Beyond, the page says: divergence.",
        meaning="The centrifugal force now compresses the beam, like the load on a column. Beyond a"
        " critical speed the straight beam is still in equilibrium, but the smallest disturbance"
        " grows: *buckling*. This time it is real.",
        fact="The straight beam buckles at γ = {:.3f}, in the plane of rotation; ω of B1 at rest is"
        " {:.3f}.",
        compute_fact=lambda: (model.first_unstable(INWARD, 5), frequency(INWARD)),
        task="Find the speed at which it buckles.",
        within=0.05,
        gauge=lambda s: s.omega_squared[0],
        reading="ω² of B1 is {:.2f}",
    ),
    Lesson(
        name="folding",
        title="Folded over its own axis",
        question="A beam that points at the axis has buckled. Where does it go?",
        guesses=("It bends aside and rests there.", "It swings for ever.", "It collapses."),
        right=0,
        scene=Scene.of(gamma=2, delta=-1, state="stable", mode=1),
        do="The **state** is set to stable. Raise **speed γ** slowly from 2 to 5.",
        see="Up to γ = 3 the beam is straight and B1 falls to zero. Then it bends aside, further"
        " with every step, and B1 rises again; at γ = 4 the tip lies behind the clamp.",
        meaning="The straight state is still an equilibrium, but an unstable one. On either side of"
        " it a bent and stable one begins: a *pitchfork bifurcation*. Bent outward, the beam is"
        " pulled, not pushed, so it stiffens again with the speed.",
        fact="At γ = 4 the tip is at x = {:.4f} L, y = {:.4f} L; ω of B1 is {:.3f}.",
        compute_fact=lambda: (*model.tip(FOLDED), frequency(FOLDED, **STABLE)),
        task="Find the speed at which the tip is exactly beside the clamp, x = 0.",
        within=0.05,
        gauge=lambda s: s.equilibrium.tip,
        reading="the tip is at x = {:.3f} L, y = {:.3f} L",
        level=0,
    ),
    Lesson(
        name="lag",
        title="Why a blade lags while it speeds up",
        question="The hub turns faster and faster. Can the beam follow it?",
        guesses=("Yes, it stays straight.", "No, it bends backwards.", "No, it bends forwards."),
        right=1,
        scene=Scene.of(gamma=5, spin_up=10, state="stable", mode=1),
        do="The speed grows at the rate λ = 10. Raise **speed γ** from 5 to 20.",
        see="The beam is bent backwards, against the rotation. The faster it rotates already, the"
        " straighter it is.",
        meaning="A beam whose hub accelerates is left behind by its inertia, as you are pressed"
        " into the seat of a car: the *Euler force*. The centrifugal force straightens the beam"
        " against it, and grows with the square of the speed.",
        fact="At γ = 5 the tip lags by {:.3f} L, at γ = 20 by {:.3f} L.",
        compute_fact=lambda: tuple(
            -model.tip(LAGGING.replace(gamma=gamma))[1] for gamma in (5, 20)
        ),
        task="Find the speed at which the tip lags by 0.3 L.",
        gauge=lambda s: -s.equilibrium.tip[1],
        reading="the tip lags by {:.3f} L",
        level=0.3,
    ),
    Lesson(
        name="stretch-jump",
        title="Where the strain jumps",
        question="Rotation makes the beam longer. Equally so on both sides of the mass?",
        guesses=("Yes, equally.", "No, more between hub and mass.", "No, more beyond the mass."),
        right=1,
        scene=Scene.of(alpha=1, beta=0.5, gamma=10, colouring="axial strain", mode=1),
        do="Orange is longer, blue is shorter than at rest. Drag **speed γ** up to 20.",
        see="The inner half turns orange first, and the colour changes at once at the mass.",
        meaning="Just inside the mass, the axial force carries the mass and the beam beyond it;"
        " just outside, only the beam. The force has a step there, so the strain has one: a"
        " *jump of the gradient*. A method that assumes a smooth strain needs very many elements"
        " to approximate it.",
        fact="At γ = 10 the beam is {:.2f} % longer just inside the mass, {:.2f} % just outside.",
        compute_fact=lambda: model.strain_at_mass(solve(MIDDLE.replace(gamma=10))),
        task="Find the speed at which it is 5 % longer just inside the mass.",
        gauge=model.strain_at_mass,
        reading="just inside +{:.2f} %, just outside +{:.2f} %",
        level=5,
    ),
    Lesson(
        name="no-equilibrium",
        title="When the material law has a limit",
        question="A program finds no equilibrium for a fast beam. Is the program wrong?",
        guesses=("Yes, every beam has an equilibrium.", "No, this material cannot carry the load."),
        right=1,
        scene=Scene.of(gamma=20, delta=1, strain="hencky", mode=1),
        do="The **strain** law is hencky (logarithmic strain). Raise"
        " **speed γ** towards 40. Then set **strain** to green.",
        see="The page says: no equilibrium, and gives the highest speed that has one. With green"
        " there is an equilibrium.",
        meaning="Under this law the axial force has a maximum, at a stretch of 2.72: a faster beam"
        " needs a larger force at its root than the material can carry. This is a *limit point*;"
        " no method can find an equilibrium beyond it. The paper that beamviz follows (Nonlinear"
        " Dynamics, 2017) saw a commercial program fail in such a case and called it less stable"
        " than its own; with this law the program would have been right.",
        fact="hencky: an equilibrium up to γ = {:.3f} (with δ = 0: {:.3f}). green has one at"
        " γ = 50 too, the root stretched {:.2f} times.",
        compute_fact=lambda: (
            model.last_equilibrium(ON_A_HUB, strain="hencky"),
            model.last_equilibrium(BARE, strain="hencky"),
            solve(ON_A_HUB.replace(gamma=50)).equilibrium.max_stretch,
        ),
        task="With hencky, find the highest speed with an equilibrium.",
        gauge=lambda s: s.equilibrium.max_stretch,
        reading="the root is stretched {:.2f} times",
    ),
)

NAMED = {each.name: each for each in LESSONS}
NAMES = tuple(NAMED)


def lesson(name: str) -> Lesson:
    """The lesson of that name; InvalidInput lists them all."""
    return NAMED[check_choice("lesson", name, NAMED)]


def lessons_table() -> str:
    """Name, title and question of each lesson, to be read in a terminal: 88 characters wide."""
    width = 2 + max(map(len, NAMES))
    wrap = textwrap.TextWrapper(88, " " * width, " " * width)
    texts = (f"{each.name:<{width}}{each.title}\n{wrap.fill(each.question)}" for each in LESSONS)
    return "\n".join(texts)
