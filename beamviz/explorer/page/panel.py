"""The controls of one visitor: they hand on what is chosen and show what is told."""

import threading
from dataclasses import asdict
from functools import partial
from typing import Any

from viser import GuiApi, GuiInputHandle, GuiSliderHandle

from beamviz.beam import Units
from beamviz.explorer.features.comparison import CompareTab
from beamviz.explorer.features.loci_tab import ChartTab
from beamviz.explorer.features.method_timing import Efforts, EffortsTab
from beamviz.explorer.features.real_beam import RealBeams
from beamviz.explorer.features.run_up import RideTab
from beamviz.explorer.features.veering import MicroscopeTab
from beamviz.explorer.page import readout
from beamviz.explorer.page.effects import Terms
from beamviz.explorer.page.inputs import Listener, Numbers, assign, heard
from beamviz.explorer.page.theme import add_style
from beamviz.explorer.request import CHOICES, MODES, Wanted
from beamviz.explorer.solver_job import Answer
from beamviz.scene import COLOURINGS, MAX_AMPLITUDE, MAX_PACE, Scene, ViewOptions
from beamviz.server.viser_private import set_html

MODEL = {
    "method": "How the beam is cut up and solved",
    "strain": "Which law ties the stretch to the force: green is the paper's",
    "curvature": "How bending is measured where the beam is stretched: spatial is the paper's",
    "plane": "chordwise: vibration in the plane of rotation; flapwise: out of it",
}
ALL = "all"
BEAM, VIEW = "beam", "view"
RIDING, BESIDE = "ride on the hub", "stand beside it"


class Panel:
    """Two panels: results over the scene on the left, controls docked on the right."""

    def __init__(self, gui: GuiApi, wanted: Wanted, view: ViewOptions, listener: Listener):
        self.listener = listener
        self.lock = threading.RLock()
        self.known = ""  # the last table
        self.choices: dict[str, GuiInputHandle] = {}  # by their keys in a scene
        gui.set_panel_label("beamviz")
        gui.main_panel.dock_right()
        gui.main_panel.set_width(320)
        add_style(gui)
        self.add_results(gui)
        with gui.add_folder("Beam"):
            self.numbers = Numbers(gui, wanted.beam(), listener, self.lock)
            RealBeams(gui, self.lock, listener)
        with gui.add_folder("Motion"):
            self.add_motion(gui, view)
        with gui.add_folder("Picture"):
            self.add_picture(gui, view)
        with gui.add_folder("Terms on or off", expand_by_default=False):
            self.terms = Terms(gui, wanted, self.numbers, listener, self.lock)
        with gui.add_folder("Model", expand_by_default=False):
            self.add_model(gui, wanted)

    def add_results(self, gui: GuiApi) -> None:
        """State, table of modes and legend, in a panel of their own."""
        self.results = results = gui.add_panel()
        with results.add_tab("Modes"):
            self.state, self.table = gui.add_html(""), gui.add_html("")
            pick = gui.add_button_group(
                "show", [*(str(k + 1) for k in range(MODES)), ALL], hint="One mode alone, or all"
            )
            pick.on_click(lambda event: self.pick(event.target.value))
            self.legend = gui.add_html("")
        with results.add_tab("Loci"):
            self.loci = ChartTab(gui, self.lock, self.listener)
        with results.add_tab("Microscope"):
            self.microscope = MicroscopeTab(gui)
        with results.add_tab("Compare"):
            self.compare = CompareTab(gui, self.lock, self.listener)
        with results.add_tab("Run-up"):
            self.ride = RideTab(gui, self.lock, self.listener)
        with results.add_tab("Methods"):
            self.efforts = EffortsTab(gui, self.lock, self.listener.weighing)
        results.dock_left()
        results.set_width(370)

    def add_motion(self, gui: GuiApi, view: ViewOptions) -> None:
        """Clock, amplitude, mix of modes and frame of view."""
        play = gui.add_checkbox("playing", view.playing)
        self.follow(play, "playing")
        speed = gui.add_slider(
            "pace",
            0.0,
            MAX_PACE,
            0.05,
            view.pace,
            hint="Speed of the one clock of rotation and vibration",
        )
        self.follow(speed, "pace")
        self.pace = gui.add_html("")
        size = gui.add_slider(
            "amplitude",
            0.0,
            MAX_AMPLITUDE,
            0.01,
            view.amplitude,
            hint="Largest displacement drawn, over the length of the beam",
        )
        self.follow(size, "amplitude")
        with gui.add_folder("Mix several modes", expand_by_default=False):
            self.shares = [self.add_share(gui, k, view) for k in range(MODES)]
        frame = gui.add_button_group("view", (RIDING, BESIDE))
        frame.on_click(
            lambda event: self.listener.see("rotating_frame", event.target.value == RIDING)
        )

    def add_share(self, gui: GuiApi, mode: int, view: ViewOptions) -> GuiSliderHandle:
        """How much of one mode is in the picture."""
        share = view.shares[mode] if mode < len(view.shares) else 0.0
        slider = gui.add_slider(
            f"mode {mode + 1}", 0.0, 1.0, 0.05, share, hint=f"How much of mode {mode + 1} is in it"
        )
        heard(slider, self.lock, partial(self.listener.share, mode))
        return slider

    def add_picture(self, gui: GuiApi, view: ViewOptions) -> None:
        """What is drawn, and how."""
        self.follow(
            gui.add_dropdown("colour", COLOURINGS, initial_value=view.colouring),
            "colouring",
        )
        self.follow(
            gui.add_checkbox(
                "ghosts",
                view.ghosts,
                hint="Outline: undeformed. Pale: stretched by the rotation, not vibrating",
            ),
            "ghosts",
        )
        self.follow(
            gui.add_checkbox("nodes", view.nodes, hint="Places that stay still in a mode"), "nodes"
        )
        self.follow(
            gui.add_checkbox("thicken", view.thicken, hint="Draw a thin beam thicker than it is"),
            "thicken",
        )
        dark = gui.add_checkbox("dark page", view.dark)
        self.follow(dark, "dark")
        reset = gui.add_button_group("reset", (BEAM, VIEW), hint="Back to how it was at first")
        reset.on_click(lambda event: self.reset(event.target.value))

    def add_model(self, gui: GuiApi, wanted: Wanted) -> None:
        """Method, strain law, curvature and plane."""
        for name, hint in MODEL.items():
            chosen = wanted.options.get(name, CHOICES[name][0])
            dropdown = gui.add_dropdown(name, CHOICES[name], initial_value=chosen, hint=hint)
            heard(dropdown, self.lock, partial(self.listener.want, name))
            self.choices[name] = dropdown

    def follow(self, control: GuiInputHandle, name: str) -> None:
        """Hand on every change of a choice of the picture."""
        self.choices[name] = control
        heard(control, self.lock, partial(self.listener.see, name))

    def pick(self, number: Any) -> None:
        """One mode alone, by its number, or all of them."""
        if number == ALL:
            self.listener.see("all_modes", True)
        elif number in [str(k + 1) for k in range(MODES)]:
            self.listener.only(int(number) - 1)

    def reset(self, what: Any) -> None:
        """The beam or the view is to be as at first."""
        if what == BEAM:
            self.listener.reset()
        elif what == VIEW:
            self.listener.reset_view()

    def show_shares(self, view: ViewOptions) -> None:
        """Put the sliders of the mix where `view` has them."""
        for k, slider in enumerate(self.shares):
            assign(slider, view.shares[k] if k < len(view.shares) else 0.0)

    def put(self, scene: Scene) -> None:
        """Put every control where `scene` has it."""
        self.numbers.show(scene.beam)
        for name, value in {**scene.options, **asdict(scene.view)}.items():
            if name in self.choices:
                assign(self.choices[name], value)
        self.show_shares(scene.view)
        self.loci.put(scene.over, scene.per_rev)

    def show(self, answer: Answer, shown: list[int]) -> None:
        """Tell what came of a wish."""
        self.terms.show(answer.wanted)
        set_html(self.state, readout.state(answer))
        if answer.solution:
            self.known = readout.table(answer.solution, shown)
        set_html(self.table, self.known if answer.solution else readout.faded(self.known))

    def weigh(self, answer: Answer | None, measured: Efforts | None) -> None:
        """Tell what the method took, and what every other takes."""
        self.efforts.show(answer.solution if answer else None, measured)

    def show_picture(
        self, colouring: str, largest: float, rate: float, units: Units | None
    ) -> None:
        """Tell the colours and the pace of the picture."""
        set_html(self.legend, readout.legend(colouring, largest, units))
        set_html(self.pace, readout.pace(rate, units))
