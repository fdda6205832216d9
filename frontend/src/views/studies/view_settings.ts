import type { MayChange, Region, StepKind, View } from "../../studies/definition";

/** A request to choose a picture. */
export interface ViewChoice {
  readonly view: View | null;
  /** The kind of the step that gets the picture. */
  readonly kind: StepKind;
  readonly use: (view: View) => void;
}

/** What the researcher has chosen besides the scene. */
export interface ViewSettings {
  readonly preset: string;
  readonly mayChange: readonly MayChange[];
  readonly start: View["start"];
  readonly region: Region | null;
}
