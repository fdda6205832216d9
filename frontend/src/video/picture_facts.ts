/** Facts about the picture on the screen. */
export interface PictureFacts {
  readonly epoch: number;
  readonly inputSeq: number;
  readonly samples: number;
  /** Relative error, infinite while unknown. */
  readonly error: number;
  readonly seconds: number;
  readonly width: number;
  readonly height: number;
  /**
   * Whether the server denoised this picture, which is then closer to the finished one than `error`
   * suggests.
   */
  readonly smoothed: boolean;
  /** Stops that automatic exposure added to the exposure of the scene. */
  readonly stops: number;
  /** The phase of the scan. */
  readonly phase: number;
}

/** The state of a picture after a pass. */
export interface ErrorPoint {
  /** Samples per pixel. */
  readonly samples: number;
  readonly seconds: number;
  readonly error: number;
}
