import type { Send } from "./sharing";
import type { Export } from "./types";

export type ScanFormat = "nifti" | "stl" | "glb";

/** What to export: all voxels (nifti), or the surface of a label or of all voxels from a value upwards. */
export interface ScanExportOrder {
  readonly format: ScanFormat;
  readonly label?: number;
  readonly above?: number;
  /** The phase of the scan for `above`, from 0. */
  readonly phase?: number;
}

/** The export of a scan that this user has requested. There is at most one. */
export interface ScanExport extends Export {
  readonly format: ScanFormat;
  readonly label: number | null;
  readonly above: number | null;
  readonly phase: number;
  /** Why it failed. */
  readonly problem: { readonly code: string; readonly text: string } | null;
}

const path = (dataSet: string): string => `/v1/data-sets/${dataSet}/export`;

export const scanExportPath = (dataSet: string): string => `${path(dataSet)}/file`;

export class ScanExportsApi {
  constructor(private readonly send: Send) {}

  async request(dataSet: string, order: ScanExportOrder): Promise<ScanExport> {
    return (await (await this.send("POST", path(dataSet), order)).json()) as ScanExport;
  }

  async state(dataSet: string): Promise<ScanExport> {
    return (await (await this.send("GET", path(dataSet))).json()) as ScanExport;
  }

  async remove(dataSet: string): Promise<void> {
    await this.send("DELETE", path(dataSet));
  }
}
