// The data of exported pages, as html_page.py and motion_page.py write them. Columns of numbers over
// speeds or moments are second differences until `undoSteps`.

type Vec3 = [number, number, number];

interface SceneCaption {
  name: string;
  text: string;
  anchor: string;
}

interface OfflineBeam {
  root: string;
  normal: Vec3;
  largest: number;
  sections: Array<[number, number]>;
  thicknesses: Array<number>;
  capped: Array<number>;
  bodies: Record<string, Array<number>>;
  labels_of_bodies: Array<{ name: string; station: number; above: Vec3 }>;
}

/** A beam of the modes of vibration; the last three are of the nodes. */
interface VibratingBeam extends OfflineBeam {
  labels: Array<string>;
  states: Array<Array<number>>;
  ring: [number, number];
  ring_colour: Array<number>;
  component: number;
}

interface MovedBeam extends OfflineBeam {
  fields: Array<Array<number>>;
  parts: Array<Array<number>>;
}

/** What both kinds have. */
interface OfflineScene {
  rate: number;
  resolution: number;
  turning: [string, number];
  palette: Array<number>;
  strain: boolean;
  beams: Array<OfflineBeam>;
}

interface OfflineSpeeds extends OfflineScene {
  beams: Array<VibratingBeam>;
  gammas: Array<number>;
  start: number;
  speeds: Array<string>;
  factor: number;
  numbers: Array<string>;
  frequencies: Record<string, Array<number>>;
  body: Array<Array<number>>;
  faces: Array<number>;
  arrow: string;
  captions: Array<Array<SceneCaption>>;
}

interface OfflineMotion extends OfflineScene {
  beams: Array<MovedBeam>;
  until: number;
  angle: Array<number>;
  with_mass: Array<boolean>;
  readings: Array<{ label: string; unit: string; values: Array<number>; decimals: number }>;
  captions: Array<SceneCaption>;
  speed: string;
  speeds: Array<string>;
  of_mass: Array<string>;
}
