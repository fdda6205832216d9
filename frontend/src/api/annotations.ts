import type { Send } from "./sharing";

/** Marks and measurements that are saved with a scan under one name. */
export interface AnnotationSet {
  readonly id: string;
  readonly name: string;
  /** Whether this user saved the set. Nobody else can change it. */
  readonly mine: boolean;
  /** Whether the marks are shown when the scan is opened. */
  readonly shown: boolean;
  readonly shared: boolean;
  /** The message `Annotations` as Protobuf JSON. */
  readonly content: unknown;
  /** Changes with the content. */
  readonly revision: string;
}

export interface AnnotationChange {
  readonly name?: string;
  readonly content?: unknown;
  /** The revision that the change is based on. The server answers 412 if there is a newer one. */
  readonly revision?: string;
  readonly shown?: boolean;
  readonly shared?: boolean;
}

/** The routes of api/openapi.yaml with the tag `annotations`, one function each. */
export class AnnotationsApi {
  constructor(private readonly send: Send) {}

  async list(dataSet: string): Promise<readonly AnnotationSet[]> {
    const response = await this.send("GET", `/v1/data-sets/${dataSet}/annotations`);
    return ((await response.json()) as { readonly items: readonly AnnotationSet[] }).items;
  }

  /** Returns the sets that the owner of a scan shares with everyone who has a link to it. */
  async follow(token: string): Promise<readonly AnnotationSet[]> {
    const response = await this.send("POST", "/v1/follow/annotations", { token });
    return ((await response.json()) as { readonly items: readonly AnnotationSet[] }).items;
  }

  async add(dataSet: string, name: string, content: unknown): Promise<AnnotationSet> {
    const response = await this.send("POST", `/v1/data-sets/${dataSet}/annotations`, { name, content });
    return (await response.json()) as AnnotationSet;
  }

  async change(dataSet: string, id: string, what: AnnotationChange): Promise<AnnotationSet> {
    const response = await this.send("PATCH", `/v1/data-sets/${dataSet}/annotations/${id}`, what);
    return (await response.json()) as AnnotationSet;
  }

  async remove(dataSet: string, id: string): Promise<void> {
    await this.send("DELETE", `/v1/data-sets/${dataSet}/annotations/${id}`);
  }
}
