import type { Send } from "./sharing";
import type { Environment } from "./types";

/** The largest file that the server accepts. */
export const mostEnvironmentBytes = 4 * 1024 * 1024;
const longestName = 60;

/** The routes for the environments that users upload to light their scans. */
export class EnvironmentsApi {
  constructor(private readonly send: Send) {}

  async list(): Promise<readonly Environment[]> {
    return ((await (await this.send("GET", "/v1/environments")).json()) as { items: Environment[] }).items;
  }

  /** Returns an environment to anyone who knows the ID, even without an account. */
  async get(id: string): Promise<Environment> {
    return (await (await this.send("GET", `/v1/environments/${id}`)).json()) as Environment;
  }

  /**
   * Uploads a file as an environment of the same name, or returns the existing one if the account
   * has one of this file.
   */
  async add(file: File): Promise<Environment> {
    const name = file.name.replace(/\.[^.]*$/, "").slice(0, longestName) || file.name.slice(0, longestName);
    const path = `/v1/environments?name=${encodeURIComponent(name)}`;
    return (await (await this.send("POST", path, new Blob([file]))).json()) as Environment;
  }

  async rename(id: string, name: string): Promise<void> {
    await this.send("PATCH", `/v1/environments/${id}`, { name });
  }

  async remove(id: string): Promise<void> {
    await this.send("DELETE", `/v1/environments/${id}`);
  }
}
