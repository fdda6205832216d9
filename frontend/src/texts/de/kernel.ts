import type { Texts } from "../shape";
import { fixed, number } from "./counting";

export const kernel: Texts["kernel"] = {
  open: "Optimierungen",
  forThisScene: (ms) =>
    `Verwendet wird ein Kernel, der in ${number.format(Math.round(ms))} ms für diese Szene kompiliert wurde.`,
  fromCache: "Verwendet wird ein Kernel, der früher für eine ähnliche Szene kompiliert wurde.",
  aheadOfTime: "Verwendet wird ein vorkompilierter, spezialisierter Kernel.",
  general: "Verwendet wird der allgemeine Kernel, der alle Funktionen enthält.",
  leftOut: "Weggelassen, weil diese Szene es nicht braucht",
  compiledIn: "Enthalten",
  nothing: "nichts",
  empty: (share) => `${fixed(100 * share, share < 0.1 ? 1 : 0)} % des Volumens sind leer und werden übersprungen.`,
  registers: (n) => `Jeder GPU-Thread belegt ${n} Register.`,
  device: (name) => name.replace(/^(\d+) CPU thread/, "$1 CPU-Thread").replace(", no GPU: ", ", keine GPU: "),
  features: {
    "area light": "Flächenlichter",
    "many lights": "mehrere Lichter",
    "shaped lights": "Scheiben- und Kugellichter",
    "textured lights": "Lichtmuster",
    environment: "Umgebungslicht",
    "textured environment": "Umgebungslicht mit Muster",
    "anisotropic phase": "anisotrope Streuung",
    surfaces: "Oberflächenschattierung",
    "hybrid shading": "gemischte Oberflächen- und Volumenschattierung",
    gloss: "Glanzlichter",
    emission: "Emission (Leuchten)",
    lens: "Schärfentiefe",
    orthographic: "orthografische Projektion",
    clip: "Schnitte",
    "clipped light": "Licht durch weggeschnittene Teile",
    slices: "Schichten im Bild",
    bounces: "Mehrfachstreuung",
    "steep extinction": "starke Dichteunterschiede",
    "denoiser guides": "Hilfsbilder zum Entrauschen",
    curves: "Deckkraftkurven",
  },
};
