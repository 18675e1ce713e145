// The messages between server and page, written by scripts/message_types.py from messages.py and
// from what the features of the page declare.

interface Axis {
  label: string;
  symbol: string;
  unit: string;
  range: [number, number];
  log: boolean;
}

interface ChartLine {
  label: string;
  y: Array<number | null>;
  runs: Array<[number, number, string, string]>;
  at?: Array<number | null>;
  second?: boolean;
  dots?: boolean;
}

interface Mark {
  key: string;
  kind: string;
  sign: string;
  style: string;
  text: string;
  x: number;
  y: number;
  action?: string;
  value?: string | number | boolean | null;
}

interface KeyEntry {
  style: string;
  text: string;
  sign: string;
}

interface Cursor {
  action: string;
  x: number;
  y?: number;
}

interface PerRev {
  slope: number;
  multiples: Array<number>;
}

interface Value {
  symbol: string;
  unit: string;
}

interface Region {
  x: number;
  y: number;
  text: string;
}

interface ChartUpdate {
  name?: string;
  message?: string;
  x?: Axis;
  y?: Axis;
  at?: Array<number | null>;
  lines?: Array<ChartLine>;
  keys?: Array<KeyEntry>;
  perRev?: PerRev | null;
  gaps?: Array<[number, number, string]>;
  marks?: Array<Mark>;
  cursor?: Cursor | null;
  chosen?: string;
  columns?: number;
  values?: Array<number | null>;
  colours?: Array<[number, number, number]>;
  range?: [number, number];
  value?: Value;
  borders?: Array<[Array<number | null>, Array<number | null>]>;
  regions?: Array<Region>;
}

interface PlacedCaption {
  name: string;
  text: string;
  anchor: string;
  hint?: boolean;
}

interface Said {
  text: string;
  error: boolean;
}

interface Update {
  bridge?: string;
  handled?: number;
  html?: Record<string, string>;
  values?: Record<string, string | number | boolean | null | Array<number>>;
  props?: Record<string, Record<string, string | number | boolean | null>>;
  charts?: Record<string, ChartUpdate>;
  captions?: Array<PlacedCaption>;
  open?: string;
  point?: Array<string>;
  focus?: string;
  dark?: boolean;
  address?: string;
  met?: Array<string>;
  answers?: Array<string>;
  used?: Array<string>;
  say?: Array<Said>;
  ready?: boolean;
}

interface Actions { // the types of their values
  "across": string;
  "adjust.between": string;
  "adjust.clear_of": string;
  "adjust.file": string;
  "adjust.free.alpha": boolean;
  "adjust.free.axial_factor": boolean;
  "adjust.free.bending_factor": boolean;
  "adjust.free.beta": boolean;
  "adjust.free.delta": boolean;
  "adjust.free.gamma": boolean;
  "adjust.free.mass_factor": boolean;
  "adjust.free.mu": boolean;
  "adjust.free.pitch": boolean;
  "adjust.free.root": boolean;
  "adjust.free.twist": boolean;
  "adjust.high.alpha": number;
  "adjust.high.axial_factor": number;
  "adjust.high.bending_factor": number;
  "adjust.high.beta": number;
  "adjust.high.delta": number;
  "adjust.high.gamma": number;
  "adjust.high.mass_factor": number;
  "adjust.high.mu": number;
  "adjust.high.pitch": number;
  "adjust.high.root": number;
  "adjust.high.twist": number;
  "adjust.low.alpha": number;
  "adjust.low.axial_factor": number;
  "adjust.low.bending_factor": number;
  "adjust.low.beta": number;
  "adjust.low.delta": number;
  "adjust.low.gamma": number;
  "adjust.low.mass_factor": number;
  "adjust.low.mu": number;
  "adjust.low.pitch": number;
  "adjust.low.root": number;
  "adjust.low.twist": number;
  "adjust.margin": number;
  "adjust.match": string;
  "adjust.measured": string;
  "adjust.run": null;
  "adjust.targets": string;
  "all_modes": boolean;
  "alpha": number;
  "amplitude": number;
  "answers": string;
  "beta": number;
  "blade.begin": null;
  "blade.file": string;
  "blade.masses": string;
  "blade.masses.add": null;
  "blade.masses.remove": number;
  "blade.paste": string;
  "blade.preset": string;
  "blade.root": string;
  "blade.spring": number;
  "blade.stations": string;
  "blade.stations.add": null;
  "blade.stations.remove": number;
  "blade.stations.sort": null;
  "blade.uniform": null;
  "cancel_export": null;
  "cancel_jobs": null;
  "colouring": string;
  "comparison": string;
  "coriolis": boolean;
  "coriolis_percent": number;
  "curvature": string;
  "damping": number;
  "dark": boolean;
  "delta": number;
  "dimensionless": null;
  "experiment": string;
  "export": string;
  "export_chart": string;
  "export_motion": string;
  "export_veering": string;
  "film_length": string;
  "flap": number;
  "following": boolean;
  "force_per_rev": string;
  "forces": boolean;
  "forget_refused": null;
  "gamma": number;
  "ghosts": boolean;
  "go_to_event": string;
  "goal": string;
  "keep": null;
  "lesson": string;
  "lesson_guess": number;
  "lesson_restart": null;
  "lesson_step": number;
  "lesson_turn": number;
  "let_go": boolean;
  "link": string;
  "load": string;
  "mapped": string;
  "mass": boolean;
  "met": string;
  "method": string;
  "moment": number;
  "motion.B1": number;
  "motion.B2": number;
  "motion.B3": number;
  "motion.begin": null;
  "motion.body": string;
  "motion.body_at": number;
  "motion.damping": number;
  "motion.hub": string;
  "motion.inertia": number;
  "motion.leave": null;
  "motion.less": null;
  "motion.pull": number;
  "motion.pull_at": number;
  "motion.start": string;
  "motion.torque": number;
  "motion.unstiffened": boolean;
  "motion.until": number;
  "motion.within": number;
  "move_beam": string;
  "mu": number;
  "nodes": boolean;
  "only": number;
  "over": string;
  "own.answer": number;
  "own.answer.1": string;
  "own.answer.2": string;
  "own.answer.3": string;
  "own.answer.4": string;
  "own.ask": string;
  "own.bring_back": null;
  "own.edit": number;
  "own.go": number;
  "own.keep": null;
  "own.move": number;
  "own.remove": null;
  "own.restore": null;
  "own.right": number;
  "own.save": null;
  "own.say": string;
  "own.show_answer": null;
  "own.tab": string;
  "own.take": null;
  "own.title": string;
  "own.turn": number;
  "pace": number;
  "per_rev_1": boolean;
  "per_rev_2": boolean;
  "per_rev_3": boolean;
  "per_rev_4": boolean;
  "per_rev_5": boolean;
  "per_rev_6": boolean;
  "pitch": number;
  "pitch_here": number;
  "plane": string;
  "playing": boolean;
  "preferences": string;
  "pull_tip": number;
  "rate": number | null;
  "real.area": number;
  "real.density": number;
  "real.diameter": number;
  "real.flap_moment": number;
  "real.length": number;
  "real.material": string;
  "real.preset": string;
  "real.second_moment": number;
  "real.section": string;
  "real.thickness": number;
  "real.wall": number;
  "real.width": number;
  "real.yield_stress": number;
  "real.youngs_modulus": number;
  "redo": null;
  "reset": null;
  "reset_view": null;
  "retry_jobs": null;
  "rotating_frame": boolean;
  "run_up": null;
  "save": null;
  "share-0": number;
  "share-1": number;
  "share-2": number;
  "share-3": number;
  "share-4": number;
  "show_shape": string;
  "softening": boolean;
  "spin_up": number;
  "stacked": boolean;
  "state": string;
  "stiffening": boolean;
  "strain": string;
  "tab": string;
  "thicken": boolean;
  "time_methods": boolean;
  "tip_path": boolean;
  "twist": number;
  "undo": null;
  "used": string;
}
