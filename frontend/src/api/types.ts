/** The answers of api/openapi.yaml that the page uses. */

export interface Me {
  readonly id: string;
  readonly email: string;
  readonly csrf_token: string;
  /** The role; it opens nothing without a second factor. */
  readonly administrator: boolean;
  /** Signing in asks for a code. */
  readonly second_factor: boolean;
  readonly quota: { readonly bytes: number; readonly used_bytes: number };
  /** Of render devices, this month. */
  readonly render_time: {
    readonly quota_ms: number;
    readonly used_ms: number;
    readonly renewed_at: string;
    /** All is used: open pictures end then. */
    readonly pictures_end_at: string | null;
  };
}

export interface BrowserSession {
  readonly id: string;
  readonly browser: string;
  readonly current: boolean;
  readonly created_at: string;
  readonly used_at: string;
}

export interface Export {
  readonly state: "queued" | "ready" | "failed";
  /** Queued, and there is no room for it at the moment. */
  readonly waiting: boolean;
  readonly bytes: number | null;
  readonly created_at: string;
  readonly expires_at: string;
}

/** An account, as an administrator sees it. */
export interface User {
  readonly id: string;
  readonly email: string;
  readonly created_at: string;
  readonly used_at: string | null;
  readonly verified: boolean;
  readonly disabled: boolean;
  readonly administrator: boolean;
  readonly quota: { readonly bytes: number; readonly used_bytes: number };
  readonly render_time: { readonly quota_ms: number; readonly used_ms: number };
  readonly data_sets: number;
}

export interface AuditEntry {
  readonly id: number;
  readonly happened_at: string;
  readonly actor: "person" | "administrator" | "machine";
  readonly actor_id: string | null;
  readonly actor_email: string | null;
  readonly action: string;
  readonly subject: string;
  readonly subject_id: string | null;
  readonly subject_email: string | null;
  readonly details: Readonly<Record<string, number | string>>;
}

export interface Fleet {
  readonly workers: readonly {
    readonly id: string;
    readonly engine: string;
    readonly device: string;
    readonly slots: number;
    readonly used: number;
    readonly load: number;
    readonly draining: boolean;
    readonly volumes: number;
  }[];
  readonly ingest: { readonly queued: number; readonly building: number };
}

export interface Listed<T> {
  readonly items: readonly T[];
  readonly next_cursor: string | null;
}

export type BodyPart = "head" | "neck" | "chest" | "abdomen" | "pelvis" | "spine" | "arm" | "leg" | "whole" | "other";
export const bodyParts: readonly BodyPart[] = [
  "head",
  "neck",
  "chest",
  "abdomen",
  "pelvis",
  "spine",
  "arm",
  "leg",
  "whole",
  "other",
];

export type DataSetState = "uploading" | "queued" | "building" | "ready" | "refused" | "expired";

export interface DataSet {
  readonly id: string;
  readonly title: string;
  readonly description: string;
  readonly body_part: BodyPart | null;
  readonly state: DataSetState;
  readonly role: "nobody" | "unverified" | "other" | "shared-view" | "shared-edit" | "owner" | "administrator";
  /** Chosen by the owner, or empty. */
  readonly owner_name: string;
  readonly owned: boolean;
  readonly is_public: boolean;
  readonly is_sample: boolean;
  /** Whoever looks at it in the gallery may have its slices. */
  readonly public_slices: boolean;
  readonly refusal: { readonly code: string; readonly text: string } | null;
  /** Queued, to the owner: what it waits for beyond its turn. */
  readonly waiting_for: "room" | "memory" | "service" | "interruption" | null;
  readonly volume: {
    readonly modality: "CT" | "MR" | "PT" | "OTHER";
    readonly size: readonly [number, number, number];
    readonly spacing_mm: readonly [number, number, number];
    readonly bytes: number;
    readonly repairs: readonly string[];
  } | null;
  readonly upload: {
    readonly url: string;
    readonly bytes: number;
    readonly received_bytes: number;
    readonly expires_at: string;
  } | null;
  /** To the owner. */
  readonly shared: { readonly people: number; readonly links: number } | null;
  readonly taken_down: { readonly reason: string } | null;
  readonly published_at: string | null;
  readonly anonymised_at: string | null;
  readonly created_at: string;
  readonly updated_at: string;
}

export interface SharedPerson {
  readonly id: string;
  readonly email: string;
  readonly may: "view" | "save";
}

export interface DataSetLink {
  readonly id: string;
  readonly expires_at: string;
  /** Whoever comes by it may have the slices. */
  readonly slices: boolean;
}

export interface Report {
  readonly id: string;
  readonly data_set_id: string;
  /** Empty once it is private again. */
  readonly title: string;
  /** What it is about; null: the data set itself. */
  readonly preset_id: string | null;
  readonly preset_name: string;
  readonly reason: string;
  readonly words: string;
  readonly taken_down: boolean;
  readonly created_at: string;
}

export interface GalleryQuery {
  readonly q: string;
  readonly body_part: string;
  readonly modality: string;
}

export interface Page<T> {
  readonly items: readonly T[];
  readonly next_cursor: string | null;
}

export interface PresetInfo {
  readonly id: string;
  readonly data_set_id: string;
  readonly name: string;
  readonly author_name: string;
  readonly mine: boolean;
  readonly is_default: boolean;
  /** The default, and its author has changed it since the owner chose it: the scan opens with what it was then. */
  readonly changed_since_default: boolean;
  readonly votes: number;
  readonly my_vote: number;
  readonly etag: string;
  /** By an administrator; then it is there for its author alone. */
  readonly taken_down: { readonly reason: string } | null;
  /** When its picture was made; null: there is none yet. */
  readonly pictured_at: string | null;
}

/** With its scene, in Protobuf's JSON. */
export interface SavedPreset extends PresetInfo {
  readonly scene: object;
}

export interface Visit {
  readonly session_id: string;
  readonly stream_url: string;
  readonly expires_at: string;
}

export interface Stream {
  readonly session_id: string;
  readonly stream_url: string;
}

export interface ProblemBody {
  readonly type: string;
  readonly title: string;
  readonly status: number;
  readonly detail?: string;
  readonly errors?: readonly { readonly field: string; readonly message: string }[];
}

export type PresetName = "skin" | "muscle" | "vessels" | "bone" | "airways";
export const presetNames: readonly PresetName[] = ["skin", "muscle", "vessels", "bone", "airways"];

export interface RecordingInfo {
  readonly id: string;
  readonly events: number;
  readonly duration_ms: number;
  readonly created_at: string;
  readonly expires_at: string;
}

export interface Recordings {
  readonly consent: boolean;
  readonly items: readonly RecordingInfo[];
}
