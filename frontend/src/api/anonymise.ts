import type { RegionBody } from "../cut/region";
import type { Send } from "./sharing";
import type { DataSetState } from "./types";

/** The response of GET and POST /v1/data-sets/{id}/anonymise. */
export interface Anonymise {
  readonly state: DataSetState;
  readonly volume_hash: string | null;
  readonly anonymised_at: string | null;
  readonly problem: string | null;
  readonly head: { readonly found: boolean; readonly sign: string; readonly proposal: RegionBody | null } | null;
}

export class AnonymiseApi {
  constructor(private readonly send: Send) {}

  async look(id: string): Promise<Anonymise> {
    return (await (await this.send("GET", `/v1/data-sets/${id}/anonymise`)).json()) as Anonymise;
  }

  /** Cuts the scan permanently. `volumeHash` identifies the volume that the user reviewed. */
  async cut(id: string, keep: RegionBody, volumeHash: string): Promise<Anonymise> {
    const body = { keep, volume_hash: volumeHash, confirm: "this cannot be undone" };
    return (await (await this.send("POST", `/v1/data-sets/${id}/anonymise`, body)).json()) as Anonymise;
  }
}
