import { afterEach, describe, expect, it } from "vitest";
import { loadTexts } from ".";
import { problemText, serverSentence } from "./problem_text";

afterEach(() => loadTexts("en"));

const problem = (kind: string, detail = "", message = "") => ({
  kind,
  detail,
  errors: message === "" ? [] : [{ field: "name", message }],
});

describe("a problem of the server", () => {
  it("uses the server's sentence in English", () => {
    expect(problemText(problem("conflict", "Somebody is quicker."))).toBe("Somebody is quicker.");
    expect(problemText(problem("invalid", "Wrong.", "must be shorter"))).toBe("must be shorter");
    expect(serverSentence("", "Try again.")).toBe("Try again.");
  });
  it("uses the German text of its type on the German page", async () => {
    await loadTexts("de");
    expect(problemText(problem("invalid", "Wrong.", "must be shorter"))).toContain("Eingabe");
    const wrongAddress = { ...problem("invalid"), errors: [{ field: "email", message: "must be an address" }] };
    expect(problemText(wrongAddress)).toContain("E-Mail-Adresse");
    expect(problemText(problem("too-many-data-sets", "You have too many scans."))).toContain("Aufnahmen");
    expect(problemText(problem("of-a-later-version", "Something new."))).toBe(problemText(problem("internal")));
    expect(problemText(problem("constructor", "x"))).toBe(problemText(problem("internal")));
  });
  it("uses the page's own text where it is better than the server's", () => {
    expect(problemText(problem("offline", "x"))).toContain("connection");
    expect(problemText(problem("code-needed", "Authentication code required"))).toContain("Reload the page");
  });
});
