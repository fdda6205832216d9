import type { Send } from "./sharing";

const path = "/v1/me/tokens";

/** What a token permits. No scope includes another. */
export type TokenScope = "read" | "write" | "share" | "archive";
export const tokenScopes: readonly TokenScope[] = ["read", "write", "share", "archive"];

/** An API token, with which programs use the account. */
export interface ApiToken {
  readonly id: string;
  readonly name: string;
  readonly scopes: readonly TokenScope[];
  readonly created_at: string;
  readonly expires_at: string;
  /** Accurate to ten minutes. Null for an unused token. */
  readonly used_at: string | null;
}

/** A new token with its text, which the server cannot show again. */
export interface NewApiToken extends ApiToken {
  readonly token: string;
}

export interface TokenOrder {
  readonly name: string;
  readonly scopes: readonly TokenScope[];
  readonly days: number;
  readonly password: string;
  /** Only with two-factor authentication. */
  readonly code?: string;
}

export class ApiTokensApi {
  constructor(private readonly send: Send) {}

  async list(): Promise<readonly ApiToken[]> {
    return ((await (await this.send("GET", path)).json()) as { items: ApiToken[] }).items;
  }

  async create(order: TokenOrder): Promise<NewApiToken> {
    return (await (await this.send("POST", path, { ...order })).json()) as NewApiToken;
  }

  async revoke(id: string): Promise<void> {
    await this.send("DELETE", `${path}/${id}`);
  }
}
