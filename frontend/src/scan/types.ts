/** What of one file's header the scan needs. Lives in the browser only; nothing of it is ever sent. */
export interface SliceHeader {
  /** Index into the files that were picked. */
  readonly file: number;
  /** Which picture of the file, of one with several that says where each lies. */
  readonly frame: number;
  /** Frames of one stack lie behind one another; "" where a file holds one slice. */
  readonly stack: string;
  readonly fileBytes: number;
  readonly sopClass: string;
  readonly sopUid: string;
  readonly studyUid: string;
  readonly seriesUid: string;
  readonly transferSyntax: string;
  readonly modality: string;
  readonly imageType: readonly string[];
  /** Was compressed with loss, which alone makes it "DERIVED". */
  readonly isLossy: boolean;
  readonly patient: Patient;
  readonly seriesNumber: number | null;
  readonly description: string;
  readonly bodyPart: string;
  readonly rows: number;
  readonly columns: number;
  /** More than one: several pictures of which it is not said where they lie. */
  readonly frames: number;
  readonly samples: number;
  readonly photometric: string;
  readonly bitsAllocated: number;
  readonly bitsStored: number;
  readonly isSigned: boolean;
  readonly hasLookupTable: boolean;
  /** Whether slope and intercept are said. */
  readonly hasScale: boolean;
  readonly slope: number;
  readonly intercept: number;
  readonly window: { readonly center: number; readonly width: number } | null;
  /** Between rows, between columns; mm. */
  readonly pixelSpacing: readonly [number, number] | null;
  /** Centre of the first pixel; mm, patient's axes (LPS). */
  readonly position: readonly [number, number, number] | null;
  /** Directions of a row and of a column. */
  readonly orientation: readonly [number, number, number, number, number, number] | null;
  /** What the file unpacks to, if it is deflated: offsets below are in there. */
  readonly inflated: Blob | null;
  /** Where the voxels are, when they are plain little-endian bytes in the file. */
  readonly pixels: { readonly offset: number; readonly length: number } | null;
  /** Where the bytes of the voxels are in the file, compressed or not; nothing where they cannot be cut out. */
  readonly voxels: {
    readonly from: number;
    readonly to: number;
    readonly vr: string;
    readonly encapsulated: boolean;
  } | null;
  /** What may leave the browser besides the voxels. */
  readonly kept: readonly KeptElement[];
  /** The same of the functional groups, of a file with several pictures: what says where this one lies. */
  readonly grouped: readonly GroupedElement[];
  /** The file ends before its voxels do. */
  readonly truncated: boolean;
}

/** A data element: its tag as "xggggeeee", its bytes as they stand in the file. */
export interface KeptElement {
  readonly tag: string;
  readonly vr: string;
  readonly bytes: Uint8Array;
}

/** An element within a functional group (DICOM PS3.3, C.7.6.16) of an enhanced file. */
export interface GroupedElement extends KeptElement {
  readonly group: string;
}

/** What is sent of a file: a new header, then a piece of the file. */
export interface UploadPart {
  readonly file: number;
  readonly head: Uint8Array<ArrayBuffer>;
  readonly from: number;
  readonly to: number;
  /** Instead of the file, if it was deflated. */
  readonly inflated: Blob | null;
}

/** What is sent of a series: its parts in order, part i with a head that ends at `headEnds[i]`. */
export interface UploadPlan {
  readonly heads: Uint8Array<ArrayBuffer>;
  readonly headEnds: Uint32Array<ArrayBuffer>;
  readonly files: Uint32Array<ArrayBuffer>;
  readonly froms: Float64Array<ArrayBuffer>;
  readonly tos: Float64Array<ArrayBuffer>;
  /** By file, of those that were deflated. */
  readonly inflated: ReadonlyMap<number, Blob>;
}

export interface Patient {
  readonly name: string;
  readonly id: string;
  readonly birthDate: string;
}

/** Why a series cannot become a volume: the codes of ingest (ingest/dicom/classify.cpp), as keys of the texts. */
export type Reason =
  | "no_slices"
  | "screenshots"
  | "scout"
  | "views_not_slices"
  | "not_original"
  | "no_position"
  | "no_spacing"
  | "bad_orientation"
  | "one_position"
  | "cine"
  | "repeated_position"
  | "repeated_identifier"
  | "time_series"
  | "mixed"
  | "lookup_table"
  | "bad_rescale"
  | "no_rescale"
  | "pixel_format"
  | "missing_slices"
  | "varying_spacing"
  | "shifted_slices"
  | "tilted"
  | "unsupported_compression"
  | "damaged"
  | "too_few_slices"
  | "too_short"
  | "too_large";

/** What ingest finds only once a scan is built (ingest/pipeline), beside those. */
export type LateReason = "over_quota" | "values_out_of_range" | "no_memory" | "upload_gone";

/** What will be mended of a suitable series, with how much of it. */
export type Repair =
  | { readonly kind: "straightened"; readonly degrees: number }
  | { readonly kind: "filled_in"; readonly slices: number }
  | { readonly kind: "varying"; readonly fromMm: number; readonly toMm: number };

export interface Suitable {
  readonly suitable: true;
  /** Voxels along a row, along a column, across slices. */
  readonly size: readonly [number, number, number];
  readonly sizeMm: readonly [number, number, number];
  readonly leftOut: LeftOut;
  readonly repairs: readonly Repair[];
}

export interface Chosen extends Suitable {
  /** The slices that are sent, from the first position to the last. */
  readonly slices: readonly SliceHeader[];
}

/** Files of a good series that do not go into the volume. */
export interface LeftOut {
  readonly scouts: number;
  readonly doubles: number;
  readonly damaged: number;
  /** Of another size than most. */
  readonly others: number;
}

export interface Unsuitable {
  readonly suitable: false;
  readonly reason: Reason;
  /** How many, where the reason counts (slices missing, slices there). */
  readonly count: number;
}

export interface Thumbnail {
  readonly width: number;
  readonly height: number;
  /** One byte a pixel, 0 black to 255 white. */
  readonly gray: Uint8Array<ArrayBuffer>;
}

export interface Series {
  readonly key: string;
  readonly description: string;
  readonly bodyPart: string;
  readonly modality: string;
  readonly seriesNumber: number | null;
  readonly patient: Patient;
  readonly slices: number;
  readonly verdict: Suitable | Unsuitable;
  readonly thumbnail: Thumbnail | null;
  /** Nothing of an unsuitable series. */
  readonly upload: UploadPlan;
  /** The same for the same files, and tells nothing about them. */
  readonly fingerprint: string;
}

export interface ScanResult {
  readonly series: readonly Series[];
  /** Files that are no DICOM, or could not be read. */
  readonly notDicom: number;
  readonly unreadable: number;
  /** Reports, screenshots, plans and the like: no slices, and never listed. */
  readonly notSlices: number;
  readonly files: number;
}
