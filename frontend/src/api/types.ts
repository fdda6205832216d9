/** The responses of api/openapi.yaml that the page uses. */

export interface Me {
  readonly id: string;
  readonly email: string;
  readonly csrf_token: string;
  /** Whether the account has the role. It is usable only with a second factor. */
  readonly administrator: boolean;
  /** Whether the account may run studies. */
  readonly researcher: boolean;
  /** Whether the account may use the hospital's archives. */
  readonly archive_access: boolean;
  /** Whether signing in requires a code. */
  readonly second_factor: boolean;
  /** Consent to the processing of health data, null until it is given to this version of the privacy notice. */
  readonly consent: { readonly version: string; readonly given_at: string | null };
  readonly quota: { readonly bytes: number; readonly used_bytes: number };
  /** Rendering time of this month. */
  readonly render_time: {
    readonly quota_ms: number;
    readonly used_ms: number;
    readonly renewed_at: string;
    /**
     * Time at which open pictures close because no rendering time is left. Null if no end is
     * scheduled.
     */
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
  /** Whether the queued export waits for free storage space. */
  readonly waiting: boolean;
  readonly bytes: number | null;
  readonly created_at: string;
  readonly expires_at: string;
}

/** An account as administrators see it. */
export interface User {
  readonly id: string;
  readonly email: string;
  readonly created_at: string;
  readonly used_at: string | null;
  readonly verified: boolean;
  readonly disabled: boolean;
  readonly administrator: boolean;
  readonly researcher: boolean;
  readonly archive_access: boolean;
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

export interface UploadInProgress {
  readonly url: string;
  readonly bytes: number;
  readonly received_bytes: number;
  readonly expires_at: string;
}

export interface DataSet {
  readonly id: string;
  readonly title: string;
  readonly description: string;
  readonly body_part: BodyPart | null;
  readonly state: DataSetState;
  readonly role: "nobody" | "unverified" | "other" | "shared-view" | "shared-edit" | "owner" | "administrator";
  /** The public name that the owner chose, or empty. */
  readonly owner_name: string;
  readonly owned: boolean;
  readonly is_public: boolean;
  readonly is_sample: boolean;
  /** Whether users of the gallery may see the slices, and save videos and large pictures. */
  readonly public_slices: boolean;
  readonly public_downloads: boolean;
  readonly refusal: { readonly code: string; readonly text: string } | null;
  /** The condition that a queued scan waits for, besides its turn. Only the owner gets it. */
  readonly waiting_for: "room" | "memory" | "service" | "interruption" | null;
  readonly volume: {
    readonly modality: "CT" | "MR" | "PT" | "OTHER";
    readonly size: readonly [number, number, number];
    /** Number of times, echoes or b-values that the scan shows. */
    readonly phases: number;
    readonly spacing_mm: readonly [number, number, number];
    readonly bytes: number;
    readonly repairs: readonly string[];
  } | null;
  readonly upload: UploadInProgress | null;
  /** The labels of a ready scan. Only the owner gets this. */
  readonly labels: {
    readonly count: number;
    readonly bytes: number;
    /** Whether the server is processing an uploaded file. */
    readonly placing: boolean;
    readonly upload: UploadInProgress | null;
    /** Why the server refused the last file. */
    readonly refusal: { readonly code: string; readonly text: string } | null;
  } | null;
  /** How many people and links have access. Sent only to the owner. */
  readonly shared: { readonly people: number; readonly links: number } | null;
  readonly taken_down: { readonly reason: string } | null;
  readonly published_at: string | null;
  readonly anonymised_at: string | null;
  readonly created_at: string;
  readonly updated_at: string;
}

/** What viewers may do besides viewing the picture, if the owner permits it. */
export interface Permissions {
  readonly slices: boolean;
  /** Videos and large pictures. */
  readonly downloads: boolean;
}

export interface SharedPerson extends Permissions {
  readonly id: string;
  readonly email: string;
  readonly may: "view" | "save";
}

export interface DataSetLink extends Permissions {
  readonly id: string;
  readonly expires_at: string;
}

/** An entry of the log of who viewed a scan. */
export interface ViewEntry {
  readonly id: string;
  readonly route: "owner" | "person" | "gallery" | "administrator" | "link" | "live-link" | "export";
  /** The address of a person, as the owner entered it. Null for other routes and for a deleted account. */
  readonly email: string | null;
  readonly link_created_at: string | null;
  /** The first part of an address, such as "203.0.0.0/16", or empty. */
  readonly network: string;
  /** Whether this request comes from the same network. */
  readonly same_network: boolean;
  readonly browser: string;
  readonly first_at: string;
  readonly last_at: string;
  readonly times: number;
}

export interface Report {
  readonly id: string;
  readonly data_set_id: string;
  /** Empty if the scan is private again. */
  readonly title: string;
  /** The reported preset, or null if the data set itself was reported. */
  readonly preset_id: string | null;
  readonly preset_name: string;
  readonly reason: string;
  readonly words: string;
  readonly taken_down: boolean;
  readonly created_at: string;
}

/** A scan or preset that an administrator has taken down. */
export interface TakeDown {
  readonly data_set_id: string;
  readonly title: string;
  /** The preset, or null if the scan itself is taken down. */
  readonly preset_id: string | null;
  readonly preset_name: string;
  readonly reason: string;
  readonly taken_down_at: string;
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
  /**
   * The preset is the default, and its author has changed it since. The scan still opens with the version that the
   * owner chose.
   */
  readonly changed_since_default: boolean;
  readonly votes: number;
  readonly my_vote: number;
  readonly etag: string;
  /** Set if an administrator took the preset down. Only its author still sees it. */
  readonly taken_down: { readonly reason: string } | null;
  /** The time at which its picture was rendered, or null if there is none yet. */
  readonly pictured_at: string | null;
}

/** A preset with its scene in Protobuf's JSON format. */
export interface SavedPreset extends PresetInfo {
  readonly scene: object;
  /** The message `Annotations` as Protobuf JSON, or null. */
  readonly annotations: unknown;
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

export const presetNames = ["skin", "muscle", "vessels", "bone", "through", "dense", "airways", "brain"] as const;
export type PresetName = (typeof presetNames)[number];

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

/** A panorama that a user has stored to light scans with. */
export interface Environment {
  readonly id: string;
  readonly mine: boolean;
  /** Sent only to the owner. */
  readonly name?: string;
  /** 32 x 16 pixels in sRGB, in hexadecimal. */
  readonly preview: string;
}
