"""The features of the page, a file each. A new one is an entry of FEATURES.

Where several change the picture, the later ones change that of the earlier ones.
"""

from beamviz.explorer.feature import Feature
from beamviz.explorer.features.adjust import AdjustTab
from beamviz.explorer.features.answer import AnswerPanel
from beamviz.explorer.features.beam_pull import BeamPull
from beamviz.explorer.features.blade import BladePanel
from beamviz.explorer.features.comparison import ComparisonTab
from beamviz.explorer.features.controls import Controls
from beamviz.explorer.features.files import Files
from beamviz.explorer.features.forces import ForcesLegend
from beamviz.explorer.features.hints import Hints
from beamviz.explorer.features.hub_turn import HubTurn
from beamviz.explorer.features.lesson_editor import LessonEditor
from beamviz.explorer.features.lesson_player import LessonPlayer
from beamviz.explorer.features.lessons import Lessons
from beamviz.explorer.features.loads import LoadsTab
from beamviz.explorer.features.loci_chart import LociTab
from beamviz.explorer.features.map import MapTab
from beamviz.explorer.features.mass_drag import MassDrag
from beamviz.explorer.features.matches import Matches
from beamviz.explorer.features.method_timing import MethodTimingTab
from beamviz.explorer.features.motion import MotionTab
from beamviz.explorer.features.real_beam import RealBeamPanel
from beamviz.explorer.features.run_up import RunUpTab
from beamviz.explorer.features.sound import Sound
from beamviz.explorer.features.veering import VeeringTab
from beamviz.explorer.features.veering_inset import VeeringInset

FEATURES: tuple[type[Feature], ...] = (
    Controls,
    AnswerPanel,
    ForcesLegend,
    Sound,
    RealBeamPanel,
    BladePanel,
    LociTab,
    MapTab,
    VeeringTab,
    VeeringInset,
    ComparisonTab,
    LoadsTab,
    RunUpTab,
    MotionTab,
    AdjustTab,
    Matches,
    MethodTimingTab,
    Lessons,
    LessonPlayer,
    LessonEditor,
    Files,
    MassDrag,
    BeamPull,
    HubTurn,
    Hints,
)
