// The list of scenes.
import { byId, make } from "./dom.js";
import { listScenes } from "./scene.js";

/**
 * Fills the list, and returns what is in it.
 * @param {string | undefined} current the path of the open scene
 * @param {(path: string, id: string | undefined) => void} open
 */
export async function showScenes(current, open) {
  const { scenes, denied } = await listScenes();
  byId("scenes").replaceChildren(
    ...scenes.map(({ path, id }) =>
      make(
        "li",
        {},
        make("button", {
          type: "button",
          "data-path": path,
          "aria-current": String(path === current),
          text: path,
          onclick: () => open(path, id),
        }),
      ),
    ),
  );
  if (scenes.length === 0) byId("scenes-note").textContent = "The server has no scenes.";
  else if (denied)
    byId("scenes-note").textContent = "Your token may only use loaded scenes: others need the role load.";
  return scenes;
}
