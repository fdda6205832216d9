import { vec3 } from "../input/vec3";
import type { Stack } from "./stack";

/** A CT of 6 x 4 x 5 voxels of 1 x 2 x 3 mm along the patient's axes, as the server tells its slices. */
export const axial: Stack = {
  plane: "axial",
  columns: 6,
  rows: 4,
  slices: 5,
  first: vec3(-2.5, -3, -6),
  right: vec3(1, 0, 0),
  down: vec3(0, 2, 0),
  next: vec3(0, 0, 3),
};
export const coronal: Stack = {
  plane: "coronal",
  columns: 6,
  rows: 5,
  slices: 4,
  first: vec3(-2.5, -3, 6),
  right: vec3(1, 0, 0),
  down: vec3(0, 0, -3),
  next: vec3(0, 2, 0),
};
export const sagittal: Stack = {
  plane: "sagittal",
  columns: 4,
  rows: 5,
  slices: 6,
  first: vec3(-2.5, -3, 6),
  right: vec3(0, 2, 0),
  down: vec3(0, 0, -3),
  next: vec3(1, 0, 0),
};

/** What the slices read of the header of the volume with these stacks. */
export const header = {
  contentHash: "a",
  windowCenter: 40,
  windowWidth: 400,
  minimum: 0,
  maximum: 9,
  percentiles: [],
  spacing: [1, 2, 3],
};
