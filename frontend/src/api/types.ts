/** The answers of api/openapi.yaml that the page uses. */

export interface Me {
  readonly id: string;
  readonly email: string;
  readonly csrf_token: string;
  readonly quota: { readonly bytes: number; readonly used_bytes: number };
}

export type DataSetState = "uploading" | "queued" | "building" | "ready" | "refused" | "expired";

export interface DataSet {
  readonly id: string;
  readonly title: string;
  readonly state: DataSetState;
  readonly owned: boolean;
  readonly is_public: boolean;
  readonly is_sample: boolean;
  readonly refusal: { readonly code: string; readonly text: string } | null;
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
  readonly created_at: string;
  readonly updated_at: string;
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

export type PresetName = "skin" | "muscle" | "vessels" | "bone";
export const preset_names: readonly PresetName[] = ["skin", "muscle", "vessels", "bone"];

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
