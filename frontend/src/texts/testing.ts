import { vi } from "vitest";
import { load_texts } from ".";

vi.stubGlobal("navigator", { languages: ["en"] }); // Node 20 has none
await load_texts("en");
