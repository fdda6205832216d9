import { describe, expect, it } from "vitest";
import { OwnView } from "./own_view";

describe("a follower's own view", () => {
  it("is being prepared until its first picture, not until the presenter's next one", () => {
    const own = new OwnView();
    own.pictureCame();
    expect(own.coming.value).toBe(false);
    own.asked(true);
    own.audienceChanged(false); // someone joined
    own.pictureCame();
    expect(own.coming.value).toBe(true);
    own.audienceChanged(true);
    expect(own.coming.value).toBe(true);
    own.pictureCame();
    expect(own.coming.value).toBe(false);
  });

  it("is no longer prepared once it is refused, given up or ended", () => {
    const own = new OwnView();
    for (const end of [
      () => own.refused(),
      () => own.asked(false),
      () => {
        own.audienceChanged(true);
        own.audienceChanged(false);
      },
    ]) {
      own.asked(true);
      end();
      expect(own.coming.value).toBe(false);
    }
  });
});
