import { vi } from "vitest";
import { loadTexts } from ".";

vi.stubGlobal("navigator", { languages: ["en"] }); // Node 20 has none
await loadTexts("en");
