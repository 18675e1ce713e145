// What the page's scripts share, and what they use of viser's page.

interface Window {
  __viserMutable?: any;
}

interface Element {
  figure?: any;
}

interface HTMLElement {
  timer?: number;
  later?: number;
}

interface EventTarget {
  closest(selector: string): any;
  matches?(selector: string): boolean;
  id: string;
}
