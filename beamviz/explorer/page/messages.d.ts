// The messages between server and page, written by scripts/message_types.py from messages.py.

interface Axis {
  label: string;
  symbol: string;
  unit: string;
  range: [number, number];
  log: boolean;
}

interface Line {
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

interface Key {
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

interface Chart {
  name?: string;
  message?: string;
  x?: Axis;
  y?: Axis;
  at?: Array<number | null>;
  lines?: Array<Line>;
  keys?: Array<Key>;
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

interface Caption {
  name: string;
  text: string;
  anchor: string;
}

interface Said {
  text: string;
  error: boolean;
}

interface Update {
  bridge?: string;
  html?: Record<string, string>;
  values?: Record<string, string | number | boolean | null | Array<number>>;
  props?: Record<string, Record<string, string | number | boolean | null>>;
  charts?: Record<string, Chart>;
  captions?: Array<Caption>;
  open?: string;
  point?: Array<string>;
  dark?: boolean;
  address?: string;
  met?: Array<string>;
  say?: Array<Said>;
  ready?: boolean;
}

type Action = [number, string, string | number | boolean | null];
