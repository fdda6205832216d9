import { randomKey } from "./random_key";
import type {
  DataSet,
  DataSetLink,
  GalleryQuery,
  Page,
  Permissions,
  PresetInfo,
  PresetName,
  Report,
  SavedPreset,
  SharedPerson,
  TakeDown,
  ViewEntry,
  Visit,
} from "./types";

/** Sends an authenticated request. Rejects with ApiProblem. */
export type Send = (method: string, path: string, body?: unknown, init?: RequestInit) => Promise<Response>;

/**
 * Returns the header with an idempotency key, so that a repeated request creates only one resource.
 */
const once = () => ({ headers: { "Idempotency-Key": randomKey() } });

const read = async <T>(response: Promise<Response>): Promise<T> => (await (await response).json()) as T;

type Hidden = Pick<TakeDown, "data_set_id" | "preset_id">;
const takeDownOf = ({ data_set_id: dataSetId, preset_id: presetId }: Hidden): string =>
  `/v1/${presetId === null ? `data-sets/${dataSetId}` : `presets/${presetId}`}/take-down`;

/** The routes of api/openapi.yaml with the tag `sharing`, one function each. */
export class SharingApi {
  constructor(private readonly send: Send) {}

  describe(id: string, what: { title?: string; description?: string; body_part?: string | null }): Promise<DataSet> {
    return read(this.send("PATCH", `/v1/data-sets/${id}`, what));
  }

  /**
   * Makes a scan public and sets what users of the gallery may do with it, or makes it private.
   */
  setVisibility(id: string, visibility: "private"): Promise<DataSet>;
  setVisibility(id: string, visibility: "public", allowed: Permissions): Promise<DataSet>;
  setVisibility(id: string, visibility: string, allowed?: Permissions): Promise<DataSet> {
    return read(this.send("POST", `/v1/data-sets/${id}/visibility`, { visibility, ...allowed }));
  }

  async people(id: string): Promise<readonly SharedPerson[]> {
    return (await read<Page<SharedPerson>>(this.send("GET", `/v1/data-sets/${id}/people`))).items;
  }

  async shareWith(id: string, email: string, may: "view" | "save", allowed: Permissions): Promise<void> {
    await this.send("POST", `/v1/data-sets/${id}/people`, { email, may, ...allowed });
  }

  /** Changes what a person may do. If they lose a permission, their sessions of the scan end. */
  async changePerson(id: string, person: string, change: Partial<Permissions>): Promise<void> {
    await this.send("PATCH", `/v1/data-sets/${id}/people/${person}`, change);
  }

  async unshare(id: string, person: string): Promise<void> {
    await this.send("DELETE", `/v1/data-sets/${id}/people/${person}`);
  }

  async links(id: string): Promise<readonly DataSetLink[]> {
    return (await read<Page<DataSetLink>>(this.send("GET", `/v1/data-sets/${id}/links`))).items;
  }

  makeLink(id: string, hours: number, allowed: Permissions): Promise<DataSetLink & { readonly path: string }> {
    return read(this.send("POST", `/v1/data-sets/${id}/links`, { hours, ...allowed }, once()));
  }

  async endLink(id: string, link: string): Promise<void> {
    await this.send("DELETE", `/v1/data-sets/${id}/links/${link}`);
  }

  /** Returns who viewed the scan, latest first. `own` includes the owner's views. */
  views(id: string, own: boolean, cursor: string | null): Promise<Page<ViewEntry>> {
    const query = new URLSearchParams({ own: String(own), ...(cursor === null ? {} : { cursor }) });
    return read(this.send("GET", `/v1/data-sets/${id}/views?${query.toString()}`));
  }

  gallery(question: GalleryQuery, cursor: string | null, signal?: AbortSignal): Promise<Page<DataSet>> {
    const query = new URLSearchParams();
    for (const [name, value] of Object.entries(question) as [string, string][])
      if (value.trim() !== "") query.set(name, value.trim());
    if (cursor !== null) query.set("cursor", cursor);
    return read(this.send("GET", `/v1/gallery?${query.toString()}`, undefined, signal ? { signal } : {}));
  }

  /** Returns what the link leads to. Needs no account. */
  follow(token: string): Promise<{ readonly data_set: DataSet; readonly expires_at: string }> {
    return read(this.send("POST", "/v1/follow", { token }));
  }

  /** Returns a picture of the scan that the link leads to. Needs no account. */
  async lookPicture(token: string, look: PresetName, signal: AbortSignal): Promise<Blob> {
    return (await this.send("POST", `/v1/follow/thumbnails/${look}`, { token }, { signal })).blob();
  }

  /** Opens a sample, or a scan by link. Needs no account. */
  visit(
    what: { readonly token: string } | { readonly data_set_id: string },
    key: string,
    signal?: AbortSignal,
  ): Promise<Visit> {
    return read(this.send("POST", "/v1/visits", { ...what, key }, signal ? { signal } : {}));
  }

  async report(id: string, reason: string, words: string): Promise<void> {
    await this.send("POST", `/v1/data-sets/${id}/reports`, { reason, words });
  }

  /** Returns the open reports. This function and the five below are for administrators. */
  async reports(): Promise<readonly Report[]> {
    return (await read<Page<Report>>(this.send("GET", "/v1/reports"))).items;
  }

  async openReports(): Promise<number> {
    return (await read<{ readonly open: number }>(this.send("GET", "/v1/report-count"))).open;
  }

  async dismiss(report: string): Promise<void> {
    await this.send("DELETE", `/v1/reports/${report}`);
  }

  /** Takes down the subject of the report, which is a preset or a scan. */
  async takeDown(report: Report, reason: string): Promise<void> {
    await this.send("POST", takeDownOf(report), { reason });
  }

  async takeDowns(): Promise<readonly TakeDown[]> {
    return (await read<Page<TakeDown>>(this.send("GET", "/v1/take-downs"))).items;
  }

  async liftTakeDown(one: TakeDown): Promise<void> {
    await this.send("DELETE", takeDownOf(one));
  }

  async publicName(): Promise<string> {
    return (await read<{ public_name: string }>(this.send("GET", "/v1/me/public-name"))).public_name;
  }

  async setPublicName(publicName: string): Promise<void> {
    await this.send("PATCH", "/v1/me/public-name", { public_name: publicName });
  }
}

/** The routes with the tag `presets`. A change names the version that it applies to by its ETag. */
export class PresetsApi {
  constructor(private readonly send: Send) {}

  async list(dataSet: string): Promise<readonly PresetInfo[]> {
    return (await read<Page<PresetInfo>>(this.send("GET", `/v1/data-sets/${dataSet}/presets`))).items;
  }

  get(id: string): Promise<SavedPreset> {
    return read(this.send("GET", `/v1/presets/${id}`));
  }

  save(dataSet: string, name: string, scene: object, annotations: unknown = null): Promise<SavedPreset> {
    return read(
      this.send("POST", `/v1/data-sets/${dataSet}/presets`, { name, scene, annotations, version: 1 }, once()),
    );
  }

  change(preset: PresetInfo, what: { name?: string; scene?: object }): Promise<SavedPreset> {
    return read(this.send("PATCH", `/v1/presets/${preset.id}`, what, { headers: { "If-Match": preset.etag } }));
  }

  async remove(preset: PresetInfo): Promise<void> {
    await this.send("DELETE", `/v1/presets/${preset.id}`, undefined, { headers: { "If-Match": preset.etag } });
  }

  async vote(preset: PresetInfo, value: -1 | 0 | 1): Promise<void> {
    await this.send("POST", `/v1/presets/${preset.id}/vote`, { value });
  }

  async setDefault(dataSet: string, preset: PresetInfo | null): Promise<void> {
    await this.send("POST", `/v1/data-sets/${dataSet}/default-preset`, { preset_id: preset?.id ?? null });
  }

  /** Creates a preset from a file in the exchange format of docs/presets.md. */
  importXml(dataSet: string, xml: Blob): Promise<SavedPreset> {
    return read(
      this.send("POST", `/v1/data-sets/${dataSet}/presets/xml`, xml, {
        headers: { ...once().headers, "Content-Type": "application/xml" },
      }),
    );
  }

  /** Returns the picture of a preset. Rejects with 404 until it exists. */
  async picture({ data_set_id: dataSetId, id }: PresetInfo, signal: AbortSignal): Promise<Blob> {
    return (await this.send("GET", `/v1/data-sets/${dataSetId}/presets/${id}/thumbnail`, undefined, { signal })).blob();
  }

  async report(id: string, reason: string, words: string): Promise<void> {
    await this.send("POST", `/v1/presets/${id}/reports`, { reason, words });
  }
}

export const presetXmlPath = (id: string): string => `/v1/presets/${id}/xml`;
