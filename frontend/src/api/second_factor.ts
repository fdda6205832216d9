import type { Send } from "./sharing";

const path = "/v1/me/second-factor";

/** The response of GET /v1/me/second-factor. */
export interface SecondFactor {
  /** Time of the setup. Null if there is no second factor. */
  readonly set_up_at: string | null;
  /** Number of unused recovery codes. */
  readonly recovery_codes: number;
  /** True for an administrator, who can use the role only with a second factor. */
  readonly required: boolean;
}

/** A new TOTP secret, which the server returns only once. */
export interface NewSecret {
  /** Base32, for typing it into an app. */
  readonly secret: string;
  /** The otpauth:// URI, which is the content of the QR code. */
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

  /** Confirms the first code and returns the recovery codes. */
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
