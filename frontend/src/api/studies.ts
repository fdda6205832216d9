import type { TourView } from "../input/view_tour";
import type { Answer, Definition, StudyLanguage, Text } from "../studies/definition";
import { randomKey } from "./random_key";
import type { Send } from "./sharing";
import type { Page, Visit } from "./types";

export type StudyState = "draft" | "open" | "closed";

export interface StudyInfo {
  readonly id: string;
  readonly title: Text;
  readonly state: StudyState;
  readonly places: number;
  readonly joined: number;
  readonly finished: number;
  readonly withdrawn: number;
  readonly ends_at: string;
  readonly created_at: string;
}

export interface Study extends StudyInfo {
  readonly definition: Definition;
  readonly etag: string;
}

export interface AnalysisTable {
  readonly title: string;
  readonly columns: readonly string[];
  readonly rows: readonly (readonly string[])[];
}
export interface AnalysisFigure {
  readonly id: string;
  readonly title: string;
  readonly svg: string;
}
export interface AnalysisSection {
  readonly id: string;
  readonly title: string;
  readonly notes: readonly string[];
  readonly tables: readonly AnalysisTable[];
  readonly figures: readonly AnalysisFigure[];
}
type Components = readonly [number, number, number];
export interface Analysis {
  readonly sections: readonly AnalysisSection[];
  readonly adoptable: {
    readonly comfort: { readonly bone: Components; readonly blood: Components } | null;
    /** The canonical views of each step in which participants choose a view. */
    readonly tours: readonly {
      readonly step: string;
      readonly data_set_id: string;
      readonly views: readonly unknown[];
    }[];
  };
}

/** The tour of a scan, through the views that the participants of a study chose. */
export interface ScanTour {
  readonly views: readonly TourView[];
  readonly participants: number;
  readonly title: Text;
  /** Whether this user can remove it. */
  readonly removable: boolean;
}

/** The changes of the colours for a comfort of 1 that a study of this installation has found. */
export interface AdoptedComfort {
  readonly bone: Components;
  readonly blood: Components;
  readonly participants: number;
  readonly title: Text;
}

/** What a link to a study leads to. */
export interface StudyInvitation {
  readonly title: Text;
  readonly languages: readonly StudyLanguage[];
  readonly consent: Text;
  /** Whether participants are asked if their interaction may be recorded. */
  readonly record: boolean;
  readonly open: boolean;
  readonly places_left: number;
  readonly steps: number;
  /** The public name of the researcher, or empty. */
  readonly researcher: string;
}

export interface JoinedStudy {
  readonly seed: number;
  readonly definition: Definition;
  /** The IDs of the steps that the server has answers to. */
  readonly answered: readonly string[];
  /** The highest sequence of these answers. */
  readonly sequence: number;
}

const read = async <T>(response: Promise<Response>): Promise<T> => (await (await response).json()) as T;
const of = (id: string): string => `/v1/studies/${id}`;
const tourOf = (dataSet: string): string => `/v1/data-sets/${dataSet}/tour`;

/** The routes of api/openapi.yaml with the tag `studies`, one function each. The first ones are for researchers. */
export class StudiesApi {
  constructor(private readonly send: Send) {}

  list(cursor: string | null): Promise<Page<StudyInfo>> {
    return read(this.send("GET", `/v1/studies${cursor === null ? "" : `?cursor=${encodeURIComponent(cursor)}`}`));
  }

  create(definition: Definition): Promise<Study> {
    return read(this.send("POST", "/v1/studies", { definition }, { headers: { "Idempotency-Key": randomKey() } }));
  }

  get(id: string): Promise<Study> {
    return read(this.send("GET", of(id)));
  }

  /** Replaces the definition. Rejects with 409 once somebody has joined. */
  save({ id, etag }: Study, definition: Definition): Promise<Study> {
    return read(this.send("PUT", of(id), { definition }, { headers: { "If-Match": etag } }));
  }

  async remove(id: string): Promise<void> {
    await this.send("DELETE", of(id));
  }

  setState(id: string, state: "open" | "closed"): Promise<Study> {
    return read(this.send("POST", `${of(id)}/state`, { state }));
  }

  /** Creates the link for participants. It ends the earlier one, and the server cannot show it again. */
  makeLink(id: string): Promise<{ readonly path: string }> {
    return read(this.send("POST", `${of(id)}/link`));
  }

  async savePicture(id: string, picture: string, file: Blob): Promise<void> {
    await this.send("PUT", `${of(id)}/pictures/${picture}`, file, { headers: { "Content-Type": file.type } });
  }

  async picture(id: string, picture: string, signal: AbortSignal): Promise<Blob> {
    return (await this.send("GET", `${of(id)}/pictures/${picture}`, undefined, { signal })).blob();
  }

  preview(id: string, key: string): Promise<JoinedStudy> {
    return read(this.send("POST", `${of(id)}/preview`, { key }));
  }

  analysis(id: string, language: StudyLanguage): Promise<Analysis> {
    return read(this.send("GET", `${of(id)}/analysis?language=${language}`));
  }

  /** Replaces the comfort of all viewers by that of a study. For administrators. */
  async adoptComfort(id: string): Promise<void> {
    await this.send("POST", `${of(id)}/adoption`, { comfort: true });
  }

  async dropComfort(): Promise<void> {
    await this.send("DELETE", "/v1/perception/comfort");
  }

  perception(): Promise<{ readonly comfort: AdoptedComfort | null }> {
    return read(this.send("GET", "/v1/perception"));
  }

  /** Uses the views of a study's step for the tour of its scan. Rejects with 403 if the scan isn't this researcher's. */
  async adoptTour(dataSet: string, study: string, step: string): Promise<void> {
    await this.send("PUT", tourOf(dataSet), { study_id: study, step });
  }

  async removeTour(dataSet: string): Promise<void> {
    await this.send("DELETE", tourOf(dataSet));
  }

  async tour(dataSet: string): Promise<ScanTour | null> {
    return (await read<{ readonly tour: ScanTour | null }>(this.send("GET", tourOf(dataSet)))).tour;
  }

  /** Returns the tour of the scan that a link leads to. */
  async followTour(token: string): Promise<ScanTour | null> {
    return (await read<{ readonly tour: ScanTour | null }>(this.send("POST", "/v1/follow/tour", { token }))).tour;
  }

  // For participants. They have no account, so each request contains their key.

  invitation(token: string): Promise<StudyInvitation> {
    return read(this.send("POST", "/v1/study/invitation", { token }));
  }

  /** The same key joins as the same participant again. */
  join(token: string, key: string, language: StudyLanguage, record: boolean): Promise<JoinedStudy> {
    return read(this.send("POST", "/v1/study/participants", { token, key, language, record }));
  }

  async answer(key: string, step: string, value: Answer, durationMs: number, sequence: number): Promise<void> {
    await this.send("POST", "/v1/study/answers", { key, step, value, duration_ms: durationMs, sequence });
  }

  async record(key: string, step: string, recording: object): Promise<void> {
    // The edge accepts a large body without an account only with this header.
    const headers = { Authorization: `Bearer ${key}` };
    await this.send("POST", "/v1/study/recordings", { key, step, recording }, { headers });
  }

  async pictureOf(key: string, picture: string, signal: AbortSignal): Promise<Blob> {
    return (await this.send("POST", "/v1/study/pictures", { key, picture }, { signal })).blob();
  }

  visit(key: string, step: string, signal: AbortSignal): Promise<Visit> {
    return read(this.send("POST", "/v1/study/visits", { key, step }, { signal }));
  }

  async finish(key: string): Promise<void> {
    await this.send("POST", "/v1/study/finish", { key });
  }

  /** Deletes the participant and their answers. Repeating it succeeds too. */
  async withdraw(key: string): Promise<void> {
    await this.send("POST", "/v1/study/withdrawal", { key });
  }
}

export const studyExportPath = (id: string, format: "json" | "csv"): string => `${of(id)}/export?format=${format}`;
