/** Pixels from the upper left of a view. */
export interface Point {
  readonly x: number;
  readonly y: number;
}

/** Of a view, in pixels. */
export interface Area {
  readonly width: number;
  readonly height: number;
}
