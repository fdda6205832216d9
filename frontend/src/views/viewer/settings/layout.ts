import type { Area } from "../../../input/flat";

/** The layout of the settings windows as plain data: which ones are open, and where. */
export const windowNames = ["view", "look", "light", "lens", "cuts", "labels", "marks"] as const;
export type WindowName = (typeof windowNames)[number];

/**
 * A docked window is at the side. A free window has its top left corner at (x, y), in pixels of the
 * page.
 */
export type Placement = { readonly docked: true } | { readonly docked: false; readonly x: number; readonly y: number };

export interface Layout {
  readonly open: readonly WindowName[];
  readonly places: Readonly<Partial<Record<WindowName, Placement>>>;
}

export const closedLayout: Layout = { open: [], places: {} };
/** The part of a window that stays inside the page, so that it can be moved back. */
const leastSeen = 80;
/** The height of a window's header. */
const headHeight = 48;

export const placeIn = (layout: Layout, name: WindowName): Placement => layout.places[name] ?? { docked: true };

/**
 * Opens a window. On a `narrow` page, it is a sheet and closes the others. Otherwise, a docked
 * window replaces another docked one, and free windows stay open.
 */
export function opened(layout: Layout, name: WindowName, narrow: boolean): Layout {
  const stays = (one: WindowName) =>
    one !== name && !narrow && !(placeIn(layout, one).docked && placeIn(layout, name).docked);
  return { ...layout, open: [...layout.open.filter(stays), name] };
}

export const closed = (layout: Layout, name: WindowName): Layout => ({
  ...layout,
  open: layout.open.filter((one) => one !== name),
});

/** Moves a window, but never out of reach. */
export function moved(layout: Layout, name: WindowName, x: number, y: number, screen: Area): Layout {
  const place: Placement = {
    docked: false,
    x: Math.round(Math.min(Math.max(x, 0), Math.max(0, screen.width - leastSeen))),
    y: Math.round(Math.min(Math.max(y, 0), Math.max(0, screen.height - headHeight))),
  };
  return { ...layout, places: { ...layout.places, [name]: place } };
}

/** Docks a window and closes the docked one. */
export function docked(layout: Layout, name: WindowName): Layout {
  const open = layout.open.filter((one) => one === name || !placeIn(layout, one).docked);
  return { open, places: { ...layout.places, [name]: { docked: true } } };
}

type Store = Pick<Storage, "getItem" | "setItem">;
const key = "diaphane.windows";

/** Restores the layout of this tab. All windows are closed if none is stored or it is damaged. */
export function rememberedLayout(store: Store): Layout {
  try {
    const value = JSON.parse(store.getItem(key) ?? "null") as { open?: unknown; places?: unknown } | null;
    const isName = (one: unknown): one is WindowName => (windowNames as readonly unknown[]).includes(one);
    const open = Array.isArray(value?.open) ? value.open.filter(isName) : [];
    const places: Partial<Record<WindowName, Placement>> = {};
    const kept =
      typeof value?.places === "object" && value.places !== null ? (value.places as Record<string, unknown>) : {};
    for (const name of windowNames) {
      const place = placementOf(kept[name]);
      if (place) places[name] = place;
    }
    return { open: [...new Set(open)], places };
  } catch {
    return closedLayout;
  }
}

function placementOf(value: unknown): Placement | null {
  if (typeof value !== "object" || value === null) return null;
  const { docked: atSide, x, y } = value as Record<string, unknown>;
  if (atSide === true) return { docked: true };
  return Number.isFinite(x) && Number.isFinite(y) ? { docked: false, x: x as number, y: y as number } : null;
}

export const rememberLayout = (store: Store, layout: Layout): void => store.setItem(key, JSON.stringify(layout));
