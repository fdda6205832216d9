import { computed, signal } from "@preact/signals";
import { local } from "../storage";

/** Light or dark: the system's setting until the user chooses one. */
type Theme = "light" | "dark";

const key = "diaphane.theme";
const device = matchMedia("(prefers-color-scheme: dark)");
const deviceDark = signal(device.matches);
device.addEventListener("change", (event) => (deviceDark.value = event.matches));

const stored = local.getItem(key);
const chosen = signal<Theme | null>(stored === "light" || stored === "dark" ? stored : null);

export const theme = computed<Theme>(() => chosen.value ?? (deviceDark.value ? "dark" : "light"));

export function toggleTheme(): void {
  chosen.value = theme.value === "dark" ? "light" : "dark";
  local.setItem(key, chosen.value);
}

theme.subscribe((value) => {
  document.documentElement.dataset.theme = value;
});
