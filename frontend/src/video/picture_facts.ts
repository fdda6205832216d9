/** What is known about the picture on the screen. */
export interface PictureFacts {
  readonly epoch: number;
  readonly inputSeq: number;
  readonly samples: number;
  /** Relative error, infinite while unknown. */
  readonly error: number;
  readonly seconds: number;
  readonly width: number;
  readonly height: number;
  /** The server denoised this picture. It is closer to the finished picture than `error` suggests. */
  readonly smoothed: boolean;
}

export interface ErrorPoint {
  readonly seconds: number;
  readonly error: number;
}
