// What the page's scripts share.

type Scalar = string | number | boolean | null;

/** The data-... attributes of elements. */
type Attributes = Partial<Record<"set" | "do" | "copy" | "value" | "paste" | "dialog" | "point" | "unit" | "row" | "panel" | "panels" | "aside" | "of" | "tones", string>>;

/** An element of the page, with the properties of all its controls and dialogs, and our own: typed:
    it has a number that the server has not; unsent: its text was changed since it was last sent;
    timer: under way. */
interface Part extends HTMLInputElement {
  closest(selector: string): Part | null;
  readonly parentElement: Part | null;
  readonly dataset: Attributes;
  open: boolean;
  selected: boolean;
  show(): void;
  showModal(): void;
  close(): void;
  typed?: boolean;
  unsent?: boolean;
  timer?: number;
  figure?: ChartOrMap;
}

/** A chart or a map (chart.js, map.js). */
interface ChartOrMap {
  set(data: ChartUpdate): void;
  reveal?(key: string): void;
}

type Pixel = [number, number]; // of a figure

/** A number as a pixel, and back. */
interface Scale {
  (value: number): number;
  invert(pixel: number): number;
}

/** A line of a chart with an x of its own. */
interface Curve extends ChartLine {
  at: number[];
}

/** What has the data of an element of a chart: a mark at a pixel. */
interface PlacedMark {
  mark: Mark;
  x: number;
  y: number;
}

/** One direction of a figure: its axis, the range shown, the scale and the pixels of its ends. */
interface Coordinate {
  axis: Axis;
  range: [number, number];
  scale: Scale;
  start: number;
  end: number;
  step: number;
}

/** The label at the end of a line. */
interface LineEnd {
  x: number;
  y: number;
  style: string;
  label: string;
  above: boolean;
}

type Styled = [tag: "b" | "em" | "span", text: string, style?: string]; // a line of a text at the pointer
