"""The lessons, in the order in which they build on each other."""

from beamviz.beam import Beam
from beamviz.errors import InvalidInput
from beamviz.lessons import reference_values as numbers
from beamviz.lessons.model import Challenge, Fact, Lesson
from beamviz.lessons.reference_values import BARE, MIDDLE, TIP, omega
from beamviz.scene import SavedScene

INWARD = Beam(delta=-1)
ON_A_HUB = Beam(delta=1)

LESSONS = (
    Lesson(
        name="stiffening",
        title="Spinning makes it stiffer",
        question="Nothing about the beam changes but its speed. Why does it swing faster?",
        scene=SavedScene.of(plane="flapwise", mode=1),
        do="Drag **speed γ** slowly from 0 up to 10.",
        see="The row B1 of the table, the slowest swing: its frequency ω climbs with the speed.",
        meaning="Every piece of the turning beam pulls outward, so the beam hangs taut between hub"
        " and tip. A taut string is harder to push aside than a slack one, and swings back"
        " faster: *centrifugal stiffening*.",
        proof=Fact(
            "At γ = 10, ω of B1 is {:.3f}; at rest it is {:.3f}.",
            lambda: (omega(BARE.replace(gamma=10), plane="flapwise"), omega(BARE)),
        ),
        challenge=Challenge(
            "Find the speed at which B1 is twice as fast as at rest.",
            "gamma",
            0.1,
            lambda: (numbers.doubling_speed(),),
            lambda s: f"B1 is {numbers.ratio_to_rest(s):.2f} times as fast as at rest",
        ),
    ),
    Lesson(
        name="two-planes",
        title="Up and down, or side to side",
        question="A helicopter blade swings up and down, and back and forth in the plane in which"
        " it turns. Which of the two is faster?",
        scene=SavedScene.of(gamma=10, mode=1),
        do="Open the folder **Model** and switch **plane** between flapwise (up and down) and"
        " chordwise (side to side).",
        see="B1 is slower side to side, as if the beam had become softer.",
        meaning="A piece that has moved aside in the plane is pulled outward in a direction that"
        " leads a little further aside: the turning helps it along. Up and down there is no"
        " such help. The loss is called *spin softening*, and it takes exactly γ² from ω².",
        proof=Fact(
            "At γ = 10, ω² of B1 is {:.3f} up and down, {:.3f} side to side: {:.3f} less.",
            lambda: (
                up := omega(BARE.replace(gamma=10), plane="flapwise") ** 2,
                aside := omega(BARE.replace(gamma=10)) ** 2,
                up - aside,
            ),
        ),
        challenge=Challenge(
            "Find the speed at which B1 is twice as fast up and down as side to side.",
            "gamma",
            0.1,
            lambda: (numbers.speed_of_double_planes(),),
            lambda s: f"it is {numbers.ratio_of_planes(s):.2f} times as fast",
            free=("plane",),
        ),
    ),
    Lesson(
        name="moving-mass",
        title="A mass moves along the beam",
        question="The mass weighs as much as the beam. Does it matter where it sits?",
        scene=SavedScene.of(alpha=1, beta=1, mode=1, over="beta"),
        do="Drag **position β** from 1, the tip, down to 0, the hub.",
        see="B1 in the table: most of the change happens in the outer half.",
        meaning="A mass slows a swing by as much as it has to move. The tip moves most; near the"
        " hub there is hardly any motion, and the mass is hardly felt. What counts is mass"
        " times the motion there squared, the *modal mass*.",
        proof=Fact(
            "ω of B1 is {:.4f} with the mass at the tip and {:.4f} with it at the hub.",
            lambda: (omega(TIP), omega(TIP.replace(beta=0))),
        ),
        challenge=Challenge(
            "Find the position at which the mass slows B1 to two thirds (0.667).",
            "beta",
            0.01,
            lambda: (numbers.place_of_two_thirds(),),
            lambda s: f"B1 is {numbers.share_of_bare(s):.3f} times what it is without the mass",
        ),
    ),
    Lesson(
        name="nodes",
        title="The mass that changes nothing",
        question="Is there a place on the beam, away from the hub, where even a heavy mass is not"
        " felt?",
        scene=SavedScene.of(alpha=1, beta=0.5, mode=2, over="beta"),
        do="The picture shows B2. Drag **position β**, then **mass α**, and watch B2 in the table.",
        see="The pink collar: there the beam stays still. When the mass comes to sit under it,"
        " making it heavier changes B2 no more.",
        meaning="A swinging beam crosses its line of rest at places that do not move at all, the"
        " *vibration nodes*. What does not move needs no force, so this mode does not feel what"
        " is put there. Other modes move there, and do feel it.",
        proof=Fact(
            "The bare beam has ω = {:.4f} and its node at {:.5f}. With a mass five times its own"
            " there, ω is {:.4f}.",
            lambda: (
                omega(BARE, "B2"),
                numbers.node(),
                omega(Beam(alpha=5, beta=numbers.node()), "B2"),
            ),
        ),
        challenge=Challenge(
            "Put the mass where B2 does not feel it.",
            "beta",
            0.006,
            lambda: (numbers.node(),),
            lambda s: f"the mass changes B2 by {100 * (numbers.share_of_bare(s, 'B2') - 1):+.2f} %",
            free=("alpha",),
        ),
    ),
    Lesson(
        name="mode-shift",
        title="Which one is the third mode?",
        question="Modes are counted from the slowest. Does the third always look the same?",
        scene=SavedScene.of(alpha=1, beta=1, mode=4, over="alpha"),
        do="Drag **mass α** from 1 to 2. The picture shows mode 4: the beam stretches.",
        see="S1 (stretching) and B3 (bending) change places in the table.",
        meaning="A mass at the tip slows the stretching, which moves the tip most, and hardly"
        " touches B3, which leaves the tip almost still. Names (S1, B3) belong to the motion,"
        " numbers only to the order: the *mode shift*.",
        proof=Fact(
            "S1 is mode {:.0f} at α = 1 and mode {:.0f} at α = 2; the two are equal at α = {:.3f}.",
            lambda: (
                numbers.place(TIP, "S1"),
                numbers.place(TIP.replace(alpha=2), "S1"),
                numbers.meeting("alpha", 3).at,
            ),
        ),
        challenge=Challenge(
            "Find the mass at which S1 and B3 are equally fast.",
            "alpha",
            0.02,
            lambda: (numbers.meeting("alpha", 3).at,),
            lambda s: f"S1 and B3 are {numbers.distance(s):.2f} apart",
        ),
    ),
    Lesson(
        name="crossing",
        title="Meeting without touching",
        question="Two frequencies run into each other as the speed grows. What happens there?",
        scene=SavedScene.of(alpha=1, beta=1, gamma=2, mode=4),
        do="Open the tab **Loci**, left: every line is one mode (a *locus*). Drag **speed γ**"
        " through the ring where S1 meets B3.",
        see="Both lines run straight on, and each keeps its motion: one stretches, one bends.",
        meaning="In this model nothing ties the stretching of a straight beam to its bending, so"
        " the two pass as if alone: a *crossing*. A chart that only sorts the numbers draws"
        " it as two curves that turn away from each other, and is easily misread.",
        proof=Fact(
            "They cross at γ = {:.4f}, both with ω = {:.3f}: gap {:.0f}.",
            lambda: (
                (event := numbers.meeting("gamma", 10)).at,
                event.frequency,
                event.gap,
            ),
        ),
        challenge=Challenge(
            "Find the speed at which B3 meets S1.",
            "gamma",
            0.05,
            lambda: (numbers.meeting("gamma", 10).at,),
            lambda s: f"S1 and B3 are {numbers.distance(s):.2f} apart",
        ),
    ),
    Lesson(
        name="veering",
        title="The same meeting, now they avoid each other",
        question="The last lesson left out one force. What does it do to the meeting?",
        scene=SavedScene.of(alpha=1, beta=1, gamma=2, coriolis=True, mode=4),
        do="**Coriolis** (folder Terms on or off) is on now. In the tab **Loci**, choose the"
        " meeting under **go to**, then open the tab **Microscope**.",
        see="Near by, the lines bend away before they touch. What was stretching leaves as bending,"
        " and the other way round.",
        meaning="What moves along a turning beam is pushed across it, as on a merry-go-round: the"
        " *Coriolis force*. It ties stretching to bending, and two frequencies that are tied"
        " together cannot be equal. They exchange their motions instead: *veering*.",
        proof=Fact(
            "The gap never falls below {:.3f}, at γ = {:.3f}.",
            lambda: (
                (event := numbers.meeting("gamma", 10, coriolis=True)).gap,
                event.at,
            ),
        ),
        challenge=Challenge(
            "Find the speed at which modes 3 and 4 come closest.",
            "gamma",
            0.1,
            lambda: (numbers.meeting("gamma", 10, coriolis=True).at,),
            lambda s: f"modes 3 and 4 are {numbers.gap(s):.3f} apart",
        ),
    ),
    Lesson(
        name="resonance",
        title="Pushed three times a turn",
        question="Wind and gravity push a blade at the same places in every turn. At which speed"
        " is that dangerous?",
        scene=SavedScene.of(gamma=5, mode=2, per_rev=True),
        do="Open the tab **Loci** and drag **speed γ** to where the dashed line 3γ meets the locus"
        " of B2.",
        see="The dashed lines 1γ, 2γ, 3γ: the frequencies of one, two, three pushes a turn.",
        meaning="A push that comes at a mode's own frequency adds to every swing before it: a"
        " *resonance*. A chart of loci with these lines is a *Campbell diagram*; machines are"
        " kept away from its meetings, or run through them fast.",
        proof=Fact(
            "Three pushes a turn meet B2 at γ = {:.3f}; one push a turn meets B1 at γ = {:.3f}.",
            lambda: (numbers.resonance(3, "B2"), numbers.resonance(1, "B1")),
        ),
        challenge=Challenge(
            "Find the speed at which three pushes a turn meet B2.",
            "gamma",
            0.1,
            lambda: (numbers.resonance(3, "B2"),),
            lambda s: (
                f"B2 swings {numbers.named(s, 'B2') / s.beam.gamma:.2f} times a turn"
                if s.beam.gamma > 0
                else "the beam does not turn"
            ),
        ),
    ),
    Lesson(
        name="paradox",
        title="The theory that breaks the beam",
        question="In the 1980s respected programs predicted that a spinning beam collapses."
        " Does it?",
        scene=SavedScene.of(gamma=2, method="zoac", mode=1),
        do="The folder **Model** is set to **zoac**, the classical linear theory. Raise **speed γ**"
        " beyond 4. Then set **method** to auto.",
        see="B1 falls to zero and the page says: unstable. With auto nothing of the kind happens.",
        meaning="The linear theory forgets that a beam that bends draws its tip inward, against"
        " the outward pull. So it has the softening of the second lesson without the"
        " stiffening of the first. Kane, Ryan and Banerjee showed it in 1987: *Kane's paradox*.",
        proof=Fact(
            "The linear theory gives up at γ = {:.3f}; in truth ω of B1 is {:.3f} there.",
            lambda: (
                (speed := numbers.first_unstable(BARE, 5, method="zoac")),
                omega(BARE.replace(gamma=speed)),
            ),
        ),
        challenge=Challenge(
            "With zoac, find the speed at which the beam seems to collapse.",
            "gamma",
            0.05,
            lambda: (numbers.first_unstable(BARE, 5, method="zoac"),),
            lambda s: f"ω² of B1 is {s.squares[0]:.2f}",
        ),
    ),
    Lesson(
        name="buckling",
        title="Pointing inward",
        question="Clamp the beam to the rim so that it points at the axis. What does spinning do"
        " to it now?",
        scene=SavedScene.of(gamma=1, delta=-1, mode=1),
        do="Hub δ is −1: the tip touches the axis. Raise **speed γ** from 1 to 3.5.",
        see="B1 falls instead of rising, and reaches zero. Beyond, the page says: unstable.",
        meaning="The outward pull now presses the beam against its clamp, like a load on a column."
        " When it outgrows the stiffness the straight beam is still in balance, but the"
        " smallest push tips it over: *buckling*. This time it is real.",
        proof=Fact(
            "The straight beam buckles at γ = {:.3f}; ω of B1 at rest is {:.3f}.",
            lambda: (numbers.first_unstable(INWARD, 5), omega(INWARD)),
        ),
        challenge=Challenge(
            "Find the speed at which it buckles.",
            "gamma",
            0.05,
            lambda: (numbers.first_unstable(INWARD, 5),),
            lambda s: f"ω² of B1 is {s.squares[0]:.2f}",
        ),
    ),
    Lesson(
        name="stretch-jump",
        title="Where the stretch jumps",
        question="The spinning beam gets longer. Equally so on both sides of the mass?",
        scene=SavedScene.of(alpha=1, beta=0.5, gamma=10, colouring="axial strain", mode=1),
        do="Orange is longer, blue is shorter than at rest. Drag **speed γ** up to 20.",
        see="The inner half turns orange first, and the colour changes at once at the mass.",
        meaning="Just inside the mass the beam must hold the mass and all that is beyond it, just"
        " outside only the rest. The pull has a step there, so the stretch has one: a"
        " *jump of the gradient*. A method that makes it smooth there needs very many"
        " elements to hide its error.",
        proof=Fact(
            "At γ = 10 the beam is {:.2f} % longer just inside the mass, {:.2f} % just outside.",
            lambda: tuple(
                100 * strain
                for strain in numbers.strain_at_mass(numbers.solve(MIDDLE.replace(gamma=10)))
            ),
        ),
        challenge=Challenge(
            "Find the speed at which it is 5 % longer just inside the mass.",
            "gamma",
            0.1,
            lambda: (numbers.speed_of_strain(0.05),),
            lambda s: "just inside +{:.2f} %, just outside +{:.2f} %".format(
                *(100 * strain for strain in numbers.strain_at_mass(s))
            ),
        ),
    ),
    Lesson(
        name="no-equilibrium",
        title="When the material gives out",
        question="A program finds no answer for a fast beam. Is the program bad?",
        scene=SavedScene.of(gamma=20, delta=1, strain="hencky", mode=1),
        do="The folder **Model** is set to the law **hencky** (logarithmic strain). Raise"
        " **speed γ** towards 40. Then set **strain** to green.",
        see="The page says: no equilibrium, and up to which speed there is one. With green the"
        " beam holds.",
        meaning="Under this law the force has a maximum: stretched to 2.72 times its length the"
        " root pulls no harder, and nothing holds a faster beam. No method can find a state that"
        " does not exist, a *limit point*. The paper saw a commercial program fail in such a"
        " scene and called it less stable than its own; with this law it would have been right"
        " (likely its law: not tested).",
        proof=Fact(
            "hencky: an equilibrium up to γ = {:.3f} (with δ = 0: {:.3f}). green has one at"
            " γ = 50 too, the root stretched {:.2f} times.",
            lambda: (
                numbers.last_equilibrium(ON_A_HUB, strain="hencky"),
                numbers.last_equilibrium(BARE, strain="hencky"),
                numbers.solve(ON_A_HUB.replace(gamma=50)).equilibrium.max_stretch,
            ),
        ),
        challenge=Challenge(
            "With hencky, find the highest speed with an equilibrium.",
            "gamma",
            0.1,
            lambda: (numbers.last_equilibrium(ON_A_HUB, strain="hencky"),),
            lambda s: f"the root is stretched {s.equilibrium.max_stretch:.2f} times",
        ),
    ),
)

NAMES = tuple(lesson.name for lesson in LESSONS)


def lesson(name: str) -> Lesson:
    """The lesson of that name; InvalidInput lists them all."""
    for one in LESSONS:
        if one.name == name:
            return one
    raise InvalidInput(f"lesson = {name}: must be one of {', '.join(NAMES)}")
