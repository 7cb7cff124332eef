// A divider that a pointer drags across a stage: left of it lies one picture, right of it the other.

// stage : element that holds the pictures; cover : the one that ends at the divider; line : the divider
export function swipe(stage, cover, line, changed) {
  let share = 0.5, on = false, held = false;

  function show() {
    line.hidden = !on;
    line.style.left = `${100 * share}%`;
    cover.style.clipPath = on ? `inset(0 ${100 * (1 - share)}% 0 0)` : "";
    line.setAttribute("aria-valuenow", String(Math.round(100 * share)));
    changed?.(share, on);
  }

  function follow(event) {
    const box = stage.getBoundingClientRect();
    share = Math.min(1, Math.max(0, (event.clientX - box.left) / box.width));
    show();
  }

  // On the divider alone: elsewhere a finger scrolls the page.
  line.addEventListener("pointerdown", (event) => {
    held = true;
    line.setPointerCapture(event.pointerId);
    event.preventDefault();
  });
  line.addEventListener("pointermove", (event) => held && follow(event));
  for (const end of ["pointerup", "pointercancel"]) line.addEventListener(end, () => (held = false));
  line.addEventListener("keydown", (event) => {
    const move = { ArrowLeft: -0.02, ArrowRight: 0.02, Home: -1, End: 1 }[event.key];
    if (move === undefined) return;
    share = Math.min(1, Math.max(0, share + move));
    show();
    event.preventDefault();
    event.stopPropagation();
  });
  show();
  return {
    get share() { return share; },
    get on() { return on; },
    set(wanted, at = share) {
      on = wanted;
      share = Math.min(1, Math.max(0, at));
      show();
    },
  };
}
