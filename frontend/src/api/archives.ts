import type { Send } from "./sharing";

export interface Archive {
  readonly name: string;
  readonly title: string;
}

/** What to search for. Empty fields match any study. */
export interface ArchiveSearch {
  readonly patient_name: string;
  readonly patient_id: string;
  readonly accession: string;
  readonly modality: "" | "CT" | "MR" | "PT";
  readonly from: string;
  readonly until: string;
}

/** A study as the archive describes it. Unknown texts are empty. */
export interface ArchiveStudy {
  readonly study: string;
  readonly patient_name: string;
  readonly patient_id: string;
  readonly birth_date: string | null;
  readonly date: string | null;
  readonly accession: string;
  readonly description: string;
  readonly modalities: readonly string[];
  readonly series: number | null;
  readonly images: number | null;
}

export interface ArchiveSeries {
  readonly series: string;
  readonly modality: string;
  readonly description: string;
  readonly body_part: string;
  /** Of a slice in mm. */
  readonly thickness: number | null;
  readonly number: number | null;
  readonly images: number | null;
  readonly suitable: boolean;
  readonly recommended: boolean;
}

export interface Fetch {
  readonly id: string;
  readonly state: "fetching" | "uploading" | "done" | "failed" | "cancelled";
  readonly images: number;
  /** 0 until the archive has listed the images. */
  readonly total: number;
  readonly uploaded: number;
  readonly data_set_id: string | null;
  readonly problem: string | null;
}

interface Order {
  readonly study: string;
  readonly series: string;
  readonly title: string;
}

const read = async <T>(response: Promise<Response>): Promise<T> => (await (await response).json()) as T;
const of = (archive: string): string => `/v1/archives/${encodeURIComponent(archive)}`;

/** The routes of api/openapi.yaml with the tag `archives`, one function each. */
export class ArchivesApi {
  constructor(private readonly send: Send) {}

  async list(): Promise<readonly Archive[]> {
    return (await read<{ items: Archive[] }>(this.send("GET", "/v1/archives"))).items;
  }

  /** `more`: the archive has more studies than these. */
  search(archive: string, search: ArchiveSearch): Promise<{ items: readonly ArchiveStudy[]; more: boolean }> {
    return read(this.send("POST", `${of(archive)}/studies`, { ...search }));
  }

  async series(archive: string, study: string): Promise<readonly ArchiveSeries[]> {
    return (await read<{ items: ArchiveSeries[] }>(this.send("POST", `${of(archive)}/series`, { study }))).items;
  }

  fetch(archive: string, order: Order): Promise<Fetch> {
    return read(this.send("POST", `${of(archive)}/fetches`, { ...order }));
  }

  status(archive: string, id: string): Promise<Fetch> {
    return read(this.send("GET", `${of(archive)}/fetches/${id}`));
  }

  async cancel(archive: string, id: string): Promise<void> {
    await this.send("DELETE", `${of(archive)}/fetches/${id}`);
  }
}
