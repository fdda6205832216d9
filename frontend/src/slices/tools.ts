import { measureKinds } from "./measure";

/** The tools for the left button or one finger. */
export const tools = ["window", "crosshair", "tilt", "curve", ...measureKinds] as const;
export type Tool = (typeof tools)[number];

/**
 * The slices that the server sends to this viewer. They are blank outside the clip unless they are `whole`. A viewer
 * who gets only the `shown` ones follows the presenter.
 */
export type Access = "none" | "shown" | "clipped" | "whole";
