import type { ArchiveFault } from "./archives";
import type { Piece } from "./piece";

/**
 * The parts of a file's header that the scan needs. Only `kept`, `grouped`, `sopClass` and
 * `transferSyntax` are sent.
 */
export interface SliceHeader {
  /** Index into the chosen files, followed by those of archives. */
  readonly file: number;
  /** Index of the frame, for a file with several frames that have positions. */
  readonly frame: number;
  /** Frames of the same stack belong together. Empty if the file contains one slice. */
  readonly stack: string;
  readonly fileBytes: number;
  readonly sopClass: string;
  readonly sopUid: string;
  readonly studyUid: string;
  readonly seriesUid: string;
  readonly transferSyntax: string;
  readonly modality: string;
  readonly imageType: readonly string[];
  /** Whether the slice was compressed with loss, which by itself makes it "DERIVED". */
  readonly isLossy: boolean;
  readonly patient: Patient;
  readonly seriesNumber: number | null;
  readonly description: string;
  readonly bodyPart: string;
  /** The date of the series, or else of the study, as yyyymmdd. May be empty. */
  readonly date: string;
  readonly rows: number;
  readonly columns: number;
  /** More than 1 if the file has several frames without positions. */
  readonly frames: number;
  readonly samples: number;
  readonly photometric: string;
  readonly bitsAllocated: number;
  readonly bitsStored: number;
  readonly isSigned: boolean;
  readonly hasLookupTable: boolean;
  /** Whether the file contains a slope and an intercept. */
  readonly hasScale: boolean;
  readonly slope: number;
  readonly intercept: number;
  readonly window: { readonly center: number; readonly width: number } | null;
  /** Distance between rows, and between columns, in mm. */
  readonly pixelSpacing: readonly [number, number] | null;
  /** Centre of the first pixel in mm, in the patient's axes (LPS). */
  readonly position: readonly [number, number, number] | null;
  /** Directions of a row and of a column. */
  readonly orientation: readonly [number, number, number, number, number, number] | null;
  /** Numbers that may distinguish slices at the same position, by the order of `distinctions` (phases.ts). */
  readonly moment: readonly (number | null)[];
  /** The content of a deflated file, to which the offsets below refer. Null if the file is not deflated. */
  readonly inflated: Blob | null;
  /** Position of the voxels in the file if they are uncompressed and little-endian, else null. */
  readonly pixels: { readonly offset: number; readonly length: number } | null;
  /** Position of the voxel data in the file, compressed or not. Null if it cannot be extracted. */
  readonly voxels: {
    readonly from: number;
    readonly to: number;
    readonly vr: string;
    readonly encapsulated: boolean;
  } | null;
  /** The elements that may be sent besides the voxels. */
  readonly kept: readonly KeptElement[];
  /**
   * The elements that may be sent of the functional groups that describe this frame of an enhanced
   * file.
   */
  readonly grouped: readonly GroupedElement[];
  /** Whether the file ends before its voxels do. */
  readonly truncated: boolean;
}

/** A data element: its tag as "xggggeeee", and its bytes as in the file. */
export interface KeptElement {
  readonly tag: string;
  readonly vr: string;
  readonly bytes: Uint8Array;
}

/** An element within a functional group (DICOM PS3.3, C.7.6.16) of an enhanced file. */
export interface GroupedElement extends KeptElement {
  readonly group: string;
}

/** The upload of a file: a new header, followed by a range of the file. */
export interface UploadPart {
  readonly file: number;
  readonly head: Uint8Array<ArrayBuffer>;
  readonly from: number;
  readonly to: number;
  /** Replaces the file if it was deflated. */
  readonly inflated: Blob | null;
}

/** The upload of a series: its parts in order. The header of part i ends at `headEnds[i]`. */
export interface UploadPlan {
  readonly heads: Uint8Array<ArrayBuffer>;
  readonly headEnds: Uint32Array<ArrayBuffer>;
  readonly files: Uint32Array<ArrayBuffer>;
  readonly froms: Float64Array<ArrayBuffer>;
  readonly tos: Float64Array<ArrayBuffer>;
  /** The content of deflated files, by index of the file. */
  readonly inflated: ReadonlyMap<number, Blob>;
  /** Whether the parts form one file, which begins with the first header. */
  readonly isOneFile: boolean;
}

export interface Patient {
  readonly name: string;
  readonly id: string;
  readonly birthDate: string;
}

/**
 * Why a series cannot become a volume. The codes are those of ingest (ingest/dicom/classify.cpp) and the keys of the
 * texts.
 */
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
  | "incomplete_phases"
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
  | "no_voxels"
  | "too_few_slices"
  | "too_short"
  | "too_large";

/** Further codes that ingest finds only when it builds a volume (ingest/pipeline). */
export type LateReason = "over_quota" | "values_out_of_range" | "no_memory" | "upload_gone";

/** A correction that will be made to a suitable series, with its extent. */
export type Repair =
  | { readonly kind: "straightened"; readonly degrees: number }
  | { readonly kind: "filled_in"; readonly slices: number }
  | { readonly kind: "varying"; readonly fromMm: number; readonly toMm: number }
  | { readonly kind: "incomplete_phases"; readonly phases: number }
  /** Slices at the ends of some phases, which other phases do not have. */
  | { readonly kind: "uncommon"; readonly slices: number }
  /** All phases together would be too large. */
  | { readonly kind: "fewer_phases"; readonly kept: number; readonly of: number }
  /** The file does not say where the patient's left, back and head are. */
  | { readonly kind: "unknown_directions" };

/** What distinguishes phases. The unit of values is ms, percent, ms or s/mm². */
export type PhaseKind = "index" | "time" | "cycle" | "echo" | "b_value";

/** The phases of a series, and the values of the first and the last one. */
export interface Phases {
  readonly kind: PhaseKind;
  readonly count: number;
  readonly range: readonly [number, number];
}

export interface Suitable {
  readonly suitable: true;
  /** Null if the series shows one moment. */
  readonly phases: Phases | null;
  /** Number of voxels along a row, along a column and across slices, of one phase. */
  readonly size: readonly [number, number, number];
  readonly sizeMm: readonly [number, number, number];
  readonly leftOut: LeftOut;
  readonly repairs: readonly Repair[];
}

export interface Chosen extends Suitable {
  /** The slices to send, in the order of their positions, phase by phase. */
  readonly slices: readonly SliceHeader[];
}

/** Numbers of files of a suitable series that do not become part of the volume. */
export interface LeftOut {
  readonly scouts: number;
  readonly doubles: number;
  readonly damaged: number;
  /** Slices whose size differs from that of most slices. */
  readonly others: number;
}

export interface Unsuitable {
  readonly suitable: false;
  readonly reason: Reason;
  /** The number in the reason, such as missing or existing slices. */
  readonly count: number;
}

export interface Thumbnail {
  readonly width: number;
  readonly height: number;
  /** One byte per pixel, from 0 (black) to 255 (white). */
  readonly gray: Uint8Array<ArrayBuffer>;
}

export interface Series {
  readonly key: string;
  readonly description: string;
  /**
   * The name of a chosen research file, which distinguishes it from others on the page and may name
   * the patient. Otherwise empty.
   */
  readonly fileName: string;
  readonly bodyPart: string;
  /** yyyymmdd, or empty. */
  readonly date: string;
  readonly modality: string;
  readonly seriesNumber: number | null;
  readonly patient: Patient;
  readonly slices: number;
  readonly verdict: Suitable | Unsuitable;
  readonly thumbnail: Thumbnail | null;
  /** Empty for an unsuitable series. */
  readonly upload: UploadPlan;
  /** Identifies the same files after a reload. It reveals nothing about them. */
  readonly fingerprint: string;
}

export interface ScanResult {
  readonly series: readonly Series[];
  /**
   * The files of archives, which follow the chosen files in the indices of the uploads. A file that
   * no upload needs is null.
   */
  readonly unpacked: readonly (Piece | null)[];
  readonly faults: readonly FaultyArchive[];
  /** Number of files in none of the supported formats. */
  readonly notDicom: number;
  readonly unreadable: number;
  /** Reports, screenshots, plans and other files without slices, which are never listed. */
  readonly notSlices: number;
  /** Number of files, including those in archives but not the archives. */
  readonly files: number;
}

/** What is wrong with a chosen archive, or with an archive in it. */
export interface FaultyArchive {
  /** Index into the chosen files. */
  readonly file: number;
  readonly fault: ArchiveFault;
}
