import { signal } from "@preact/signals";
import { createContext } from "preact";
import { useContext } from "preact/hooks";
import { Api, ApiProblem } from "../api/client";
import type { Me } from "../api/types";
import { Uploads } from "../api/uploads";
import { setAdoptedComfort } from "../scene/comfort";
import { tab } from "../storage";
import { t } from "../texts";
import { problemText } from "../texts/problem_text";

const askedAgainAfterMs = 2000;

/** An error message for the user. */
export class UserError extends Error {}

/** The state that all pages share. */
export class AppState {
  readonly api = new Api();
  readonly uploads = new Uploads(this.api);
  /** Null if nobody is signed in, undefined until the server has responded. */
  readonly me = signal<Me | null | undefined>(undefined);
  /** Whether the first request has failed so far. It is repeated until it succeeds. */
  readonly unreachable = signal(false);
  /** A message that the front page shows once after `leave`. */
  readonly signOutNotice = signal("");
  private again: ReturnType<typeof setTimeout> | undefined;

  async load(): Promise<void> {
    clearTimeout(this.again);
    try {
      const [me] = await Promise.all([this.api.me(), this.loadPerception()]);
      this.me.value = me;
      this.unreachable.value = false;
    } catch {
      this.unreachable.value = true;
      this.again = setTimeout(() => void this.load(), askedAgainAfterMs);
    }
  }

  /** Loads what studies of this installation have found. Without an answer, the published values stay. */
  private async loadPerception(): Promise<void> {
    setAdoptedComfort(
      await this.api.studies.perception().then(
        ({ comfort }) => comfort,
        () => null,
      ),
    );
  }

  signedIn(me: Me): void {
    if (this.me.value && this.me.value.id !== me.id) {
      // The link in an email may sign in another user than the current one.
      this.uploads.stopAll();
      tab.clear();
    }
    this.me.value = me;
  }

  async signOut(): Promise<void> {
    this.uploads.stopAll();
    try {
      await this.api.signOut();
    } finally {
      tab.clear();
      this.me.value = null;
    }
  }

  /** Signs the user out on this page. The front page shows `signOutNotice`. */
  leave(signOutNotice: string): void {
    tab.clear();
    this.signOutNotice.value = signOutNotice;
    this.me.value = null;
  }

  /**
   * Returns a message for an error. If the session has expired, also shows the sign-in page, and if
   * the privacy notice has changed, asks for consent again.
   */
  explain(thrown: unknown): string {
    if (thrown instanceof UserError) return thrown.message;
    if (!(thrown instanceof ApiProblem)) return t.problems.internal;
    if (thrown.kind === "unauthenticated") this.me.value = null;
    if (thrown.kind === "consent-needed") void this.load();
    return problemText(thrown);
  }
}

export const AppContext = createContext<AppState | null>(null);

export function useApp(): AppState {
  const app = useContext(AppContext);
  if (!app) throw new Error("outside of the app");
  return app;
}
