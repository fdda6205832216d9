import { readMetaImage } from "./meta_image";
import { readNifti } from "./nifti";
import { readNrrd } from "./nrrd";
import type { ImageRead } from "./header";

/** Reads the header of a file in a research format. */
export const readImage = (bytes: Uint8Array): ImageRead => readNifti(bytes) ?? readNrrd(bytes) ?? readMetaImage(bytes);
