"""Test images, their ground truth and the predictions of each row."""

from foggy_synscapes.figures.figure import IMAGES, METRICS, PREDICTIONS, RUNS, Drawing, Figure, Sources
from foggy_synscapes.figures.panels import colour, grid
from foggy_synscapes.labels import CLASSES, IGNORE
from foggy_synscapes.scoring.confusion import confusion_matrix
from foggy_synscapes.scoring.iou import iou, mean_annotated


def draw(sources: Sources) -> Drawing:
    """In the corner of each prediction stands the mean IoU of this single image."""
    samples = sources.images(sources.params.figures.images)
    lines, names, notes = [], [], []
    for network, title in sources.networks.items():
        block = [[sample.rgb, colour(sample.truth)] for sample in samples]
        scores = [["", ""] for _ in samples]
        for row in sources.rows:
            found = sources.predictions(network, row, [sample.name for sample in samples])
            for sample, predicted, images, texts in zip(samples, found, block, scores, strict=True):
                # The paper paints unlabelled pixels of predictions too; only the score leaves them out.
                images.append(colour(predicted))
                matrix = confusion_matrix(sample.truth, predicted, len(CLASSES), IGNORE)
                texts.append(f"{100 * mean_annotated(iou(matrix)):.0f}")
        lines += block
        notes += scores
        names += [title] * len(samples)
    title = f"{sources.title()}: predictions of each row; in the corner, mean IoU of the image in percent"
    return grid(lines, ["image", "ground truth", *sources.rows], names, notes, legend=True, title=title)


FIGURE = Figure(
    text="Test images, their ground truth and what each row predicts, in the colours of Cityscapes; the "
    "number in a corner is the mean IoU of that one image in percent.",
    inputs=(IMAGES, METRICS, PREDICTIONS),
    keys=(*RUNS, "scenes.roots"),
    draw=draw,
    of_test_set=True,
)
