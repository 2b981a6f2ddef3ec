"""A network of an ONNX file, run by onnxruntime on one thread."""

NEEDED = "tracking needs onnxruntime: pip install 'snowsim[track]'"


def network(weights, where="weights"):
    """Logits of a stack of inputs, both float32 (patch, 1, row, range_line), as a function.

    ValueError where onnxruntime is missing, or takes the bytes for no network of this input.
    """
    try:
        import onnxruntime
    except ImportError as error:
        raise ValueError(NEEDED) from error
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    options.inter_op_num_threads = 1
    # Windows differ in size: what was kept for the largest would stay.
    options.enable_cpu_mem_arena = False
    providers = ["CPUExecutionProvider"]
    try:
        session = onnxruntime.InferenceSession(weights, options, providers=providers)
    except Exception as error:  # of a kind that onnxruntime does not export
        msg = f"{where}: expected an ONNX network, {type(error).__name__}"
        raise ValueError(msg) from error
    inputs = [each.name for each in session.get_inputs()]
    outputs = [each.name for each in session.get_outputs()]
    if (inputs, outputs) != (["image"], ["logit"]):
        msg = f"{where}: expected input image and output logit, found {inputs} and {outputs}"
        raise ValueError(msg)

    def run(images):
        (logits,) = session.run(["logit"], {"image": images})
        return logits

    return run
