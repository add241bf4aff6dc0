"""Two references of the transfer of indirect light, in float64, dense and plain."""

import numpy as np


def notebook(direct, indirect, rank, ridge):
    """The notebook's mathematics, on images of norm 1 around their mean; returns the predictor.

    Without its clip to 0 .. 1, which loses what is bright, and with its eigenvectors in order.
    """
    images, height, width, _ = indirect.shape
    x = direct.reshape(images, -1)
    norm = np.linalg.norm(x, axis=1, keepdims=True)
    x = x / norm
    y = indirect.transpose(0, 3, 1, 2).reshape(images, 3, -1) / norm[:, None]
    rows = y.reshape(3 * images, -1)
    mean = rows.mean(axis=0)
    values, vectors = np.linalg.eigh((rows - mean) @ (rows - mean).T / (images - 1))
    most = vectors[:, np.argsort(-values)[:rank]]
    B = np.linalg.qr((most.T @ (rows - mean)).T, mode="reduced")[0].T
    coefficients = (y - mean) @ B.T
    inverse = np.linalg.pinv(x.T @ x + ridge * np.eye(x.shape[1]))
    T = np.einsum("ij,jk,kcr->cir", inverse, x.T, coefficients)

    def predict(image):
        length = np.linalg.norm(image)
        z = np.stack([image.ravel() / length @ T[channel] @ B + mean for channel in range(3)])
        return length * z.T.reshape(height, width, 3)

    return predict


def channelwise(direct, indirect, rank, ridge):
    """No mean, and each channel from its own: by SVD of all texels and normal equations."""
    images, height, width, _ = indirect.shape
    norm = np.linalg.norm(direct.reshape(images, -1), axis=1)[:, None, None]
    x = direct.transpose(0, 3, 1, 2).reshape(images, 3, -1) / norm
    y = indirect.transpose(0, 3, 1, 2).reshape(images, 3, -1) / norm
    B = np.linalg.svd(y.reshape(3 * images, -1), full_matrices=False)[2][:rank]

    def predict(image):
        z = []
        for channel in range(3):
            X = x[:, channel]
            T = np.linalg.solve(X.T @ X + ridge * np.eye(X.shape[1]), X.T @ y[:, channel] @ B.T)
            z.append(image[..., channel].ravel() @ T @ B)
        return np.stack(z, axis=-1).reshape(height, width, 3)

    return predict
