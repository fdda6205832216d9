/** A point in pixels from the top left corner of a view. */
export interface Point {
  readonly x: number;
  readonly y: number;
}

/** The size of a view in pixels. */
export interface Area {
  readonly width: number;
  readonly height: number;
}
