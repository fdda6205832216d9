import { defineConfig } from "vite";
import { fakeServer } from "./server";

/**
 * The page against a made-up server, to work on it without the programs, and to test it (`vite preview`, which serves
 * the built page). Never built, never shipped.
 */
export default defineConfig({ root: ".", plugins: [fakeServer()], server: { port: 5180, strictPort: true } });
