// The data of exported pages, written by scripts/message_types.py from offline_data.py. Columns of
// numbers over speeds or moments are second differences until `undoSteps`.

type Vec3 = [number, number, number];

interface SceneCaption {
  name: string;
  text: string;
  anchor: string;
}

interface BodyLabel {
  name: string;
  station: number;
  above: [number, number, number];
}

interface Surface {
  rings: Array<[number, number, number]>;
  normals: Array<[number, number, number]>;
  faces: Array<number>;
}

interface OfflineBeam {
  root: string;
  largest: number;
  sections: Array<[number, number]>;
  turns: Array<number>;
  capped: Array<number>;
  bodies: Record<string, Array<number>>;
  labels_of_bodies: Array<BodyLabel>;
  surface: Surface | null;
}

interface VibratingBeam {
  root: string;
  largest: number;
  sections: Array<[number, number]>;
  turns: Array<number>;
  capped: Array<number>;
  bodies: Record<string, Array<number>>;
  labels_of_bodies: Array<BodyLabel>;
  surface: Surface | null;
  modes: Array<string>;
  equilibrium: number;
  states: Array<Array<number>>;
  ring: [number, number];
  ring_colour: Array<number>;
  component: number;
  path: [number, number, number] | null;
}

interface MovedBeam {
  root: string;
  largest: number;
  sections: Array<[number, number]>;
  turns: Array<number>;
  capped: Array<number>;
  bodies: Record<string, Array<number>>;
  labels_of_bodies: Array<BodyLabel>;
  surface: Surface | null;
  fields: Array<Array<number>>;
  parts: Array<Array<number>>;
}

interface OfflineScene {
  rate: number;
  resolution: number;
  turning: [string, number];
  palette: Array<number>;
  strain: boolean;
  beams: Array<OfflineBeam>;
}

interface OfflineEquilibrium {
  vertices: Array<Array<number>>;
  faces: Array<number>;
}

interface OfflineSpeeds {
  rate: number;
  resolution: number;
  turning: [string, number];
  palette: Array<number>;
  strain: boolean;
  beams: Array<VibratingBeam>;
  gammas: Array<number>;
  start: number;
  speeds: Array<string>;
  factor: number;
  numbers: Array<string>;
  frequencies: Record<string, Array<number>>;
  equilibria: Array<OfflineEquilibrium>;
  arrow: string;
  captions: Array<Array<SceneCaption>>;
}

interface Reading {
  label: string;
  unit: string;
  values: Array<number>;
  decimals: number;
}

interface OfflineMotion {
  rate: number;
  resolution: number;
  turning: [string, number];
  palette: Array<number>;
  strain: boolean;
  beams: Array<MovedBeam>;
  until: number;
  angle: Array<number>;
  with_mass: Array<boolean>;
  readings: Array<Reading>;
  captions: Array<SceneCaption>;
  speed: string;
  speeds: Array<string>;
  of_mass: Array<string>;
}
