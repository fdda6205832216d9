import type { Send } from "./sharing";

const path = "/v1/me/second-factor";

/** The answer of GET /v1/me/second-factor. */
export interface SecondFactor {
  /** Null: there is none. */
  readonly set_up_at: string | null;
  /** That were not used yet. */
  readonly recovery_codes: number;
  /** An administrator's: without it the role opens nothing. */
  readonly required: boolean;
}

/** Shown once. */
export interface NewSecret {
  /** In base 32, for who types it. */
  readonly secret: string;
  /** otpauth://, what a QR code holds. */
  readonly uri: string;
}

export class SecondFactorApi {
  constructor(private readonly send: Send) {}

  async look(): Promise<SecondFactor> {
    return (await (await this.send("GET", path)).json()) as SecondFactor;
  }

  async begin(password: string): Promise<NewSecret> {
    return (await (await this.send("POST", path, { password })).json()) as NewSecret;
  }

  /** The first code; gives the recovery codes. */
  confirm(code: string): Promise<readonly string[]> {
    return this.codes("confirm", { code });
  }

  renewRecoveryCodes(password: string, code: string): Promise<readonly string[]> {
    return this.codes("recovery-codes", { password, code });
  }

  async remove(password: string, code: string): Promise<void> {
    await this.send("POST", `${path}/removal`, { password, code });
  }

  private async codes(which: string, body: object): Promise<readonly string[]> {
    const answer = await this.send("POST", `${path}/${which}`, body);
    return ((await answer.json()) as { recovery_codes: string[] }).recovery_codes;
  }
}
