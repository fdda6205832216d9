import { signal } from "@preact/signals";

/**
 * Whether a follower's own view is still being prepared, which takes seconds on a busy server.
 * Until then, the presenter's last picture stays on the screen.
 */
export class OwnView {
  readonly coming = signal(false);
  private isThere = false;

  asked(on: boolean): void {
    this.coming.value = on;
  }

  refused(): void {
    this.coming.value = false;
  }

  /** `isThere`: whether the server now sends pictures of the own view, and no others. */
  audienceChanged(isThere: boolean): void {
    if (this.isThere && !isThere) this.coming.value = false; // someone with an account needs the place
    this.isThere = isThere;
  }

  /** A new picture is on the screen. */
  pictureCame(): void {
    if (this.isThere) this.coming.value = false;
  }
}
